//! Fits a circle to edge points of which a part may lie on something else.
//!
//! The centre of most points comes from circles through three of them, spread over the directions; the rest is iteratively
//! reweighted least squares of the distances from the circle (Tukey's weights), without the points of an arc that does not
//! belong to it and without those beside such an arc, where an edge passes into another one gradually.

/// An edge point on a ray from a provisional centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgePoint {
    /// distance from the provisional centre, px
    pub distance: f32,
    /// 0 where no edge was found
    pub weight: f32,
    /// how many times as far it may be from its circle as a sharp edge
    pub scale: f32,
}

impl EdgePoint {
    pub const NONE: EdgePoint = EdgePoint {
        distance: 0.0,
        weight: 0.0,
        scale: 1.0,
    };
}

/// Where a disc is, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
}

impl Disc {
    /// The same where its centre was counted from another's.
    pub fn about_centre_of(self, other: Disc) -> Disc {
        Disc {
            x: other.x + self.x,
            y: other.y + self.y,
            ..self
        }
    }

    /// Distance of both centres.
    pub fn distance(self, other: Disc) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}

/// A fitted circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub disc: Disc,
    /// rays whose edge belongs to the circle, of all
    pub share: f64,
    /// robust sd of the distances of these, px
    pub scatter: f64,
}

/// Directions of rays from a centre, evenly over the circle.
pub(super) struct Rays {
    pub directions: Vec<(f64, f64)>,
}

impl Rays {
    pub fn new(count: usize) -> Rays {
        let angle = |j: usize| std::f64::consts::TAU * j as f64 / count as f64;
        Rays {
            directions: (0..count).map(|j| (angle(j).cos(), angle(j).sin())).collect(),
        }
    }

    /// The circle through most of the edge points, one a ray, its centre from the provisional one; with its radius if that is
    /// known. `None` where fewer than a
    /// quarter of the rays agree, or where these look all one way.
    pub fn fit(&self, edges: &[EdgePoint], radius: Option<f64>) -> Option<Circle> {
        let mut points = self.points(edges);
        let found = edges.iter().filter(|edge| edge.weight > 0.0);
        let typical = median(found.map(|edge| f64::from(edge.distance)))?;
        let rough = (ROUGH * radius.unwrap_or(typical)).max(0.5);
        let refitted = |points: &[Point], circle: &Disc, scatter: f64| {
            let weigh = |point: &Point| tukey(point.away(circle) / (TUKEY * scatter));
            step(points, circle, radius, weigh)
        };
        let mut circle = consensus(&points, radius, rough)?;
        let mut scatter = rough;
        for _ in 0..ROUNDS {
            let near = points.iter().filter(|point| point.weight > 0.0);
            let away = near.map(|point| point.away(&circle).abs()).filter(|away| *away < rough);
            // a scatter that shrinks by half at most keeps the arc in view while the centre still moves
            scatter = (1.4826 * median(away)?).clamp(LEAST_SCATTER.max(0.5 * scatter), rough);
            let next = refitted(&points, &circle, scatter)?;
            let moved = next.distance(circle) + (next.radius - circle.radius).abs();
            circle = next;
            if moved < 1e-4 && scatter < rough {
                break;
            }
        }
        leave_wrong_arcs_out(&mut points, &circle, OUTSIDE * scatter);
        for _ in 0..ROUNDS {
            let next = refitted(&points, &circle, scatter)?;
            let moved = next.distance(circle);
            circle = next;
            if moved < 1e-6 {
                break;
            }
        }
        let is_used = |point: &&Point| point.weight > 0.0 && point.away(&circle).abs() < OUTSIDE * scatter;
        let share = points.iter().filter(is_used).count() as f64 / self.directions.len().max(1) as f64;
        (share >= LEAST_SHARE).then_some(Circle {
            disc: circle,
            share,
            scatter,
        })
    }

    fn points(&self, edges: &[EdgePoint]) -> Vec<Point> {
        let each = edges.iter().zip(&self.directions);
        each.map(|(edge, (nx, ny))| Point {
            x: f64::from(edge.distance) * nx,
            y: f64::from(edge.distance) * ny,
            weight: f64::from(edge.weight),
            scale: f64::from(edge.scale),
        })
        .collect()
    }
}

/// Distances from a circle that may be of its edge, in radii, before anything else is known.
const ROUGH: f64 = 0.06;
/// Rounds of reweighting; a handful are enough.
const ROUNDS: usize = 20;
/// Least scatter that edges are taken to have, px.
const LEAST_SCATTER: f64 = 0.03;
/// Tukey's constant: 95 % efficient where errors are normal.
const TUKEY: f64 = 4.685;
/// Scatters beyond which a point is not of the circle.
const OUTSIDE: f64 = 3.5;
/// Rays below which a fit is none.
const LEAST_SHARE: f64 = 0.25;

struct Point {
    x: f64,
    y: f64,
    weight: f64,
    scale: f64,
}

impl Point {
    /// The distance from a circle, outwards, beside what a sharp edge has.
    fn away(&self, circle: &Disc) -> f64 {
        (length(self.x - circle.x, self.y - circle.y) - circle.radius) / self.scale
    }
}

/// Of lengths of an image, which neither overflow nor vanish: `hypot` takes several times as long.
fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

fn tukey(u: f64) -> f64 {
    let rest = (1.0 - u * u).max(0.0);
    rest * rest
}

/// The circle through three points that most others are near to.
fn consensus(points: &[Point], radius: Option<f64>, rough: f64) -> Option<Disc> {
    let count = points.len();
    /// Starts over the circle.
    const STARTS: usize = 24;
    /// Part of all points that a circle has of which there is no second.
    const CLEAR: f64 = 0.8;
    // angles between the three, in parts of a turn: wide ones are exact, narrow ones fit into an arc that is left
    let steps = [(3, 3), (4, 4), (4, 3), (6, 6), (8, 6)];
    let all: f64 = points.iter().map(|point| point.weight / point.scale).sum();
    let mut best: Option<(f64, Disc)> = None;
    for (first, second) in steps {
        for start in 0..STARTS {
            let turns = [0, count / first, count / first + count / second];
            let [a, b, c] = turns.map(|turn| &points[(start * count / STARTS + turn) % count]);
            if a.weight * b.weight * c.weight == 0.0 {
                continue;
            }
            let Some(mut trial) = through(a, b, c) else { continue };
            if let Some(radius) = radius {
                trial.radius = radius;
            }
            let scores = points
                .iter()
                .map(|point| point.weight * tukey(point.away(&trial) / rough) / point.scale);
            let score: f64 = scores.sum();
            if score > CLEAR * all {
                return Some(trial);
            }
            if best.as_ref().is_none_or(|(most, _)| score > *most) {
                best = Some((score, trial));
            }
        }
    }
    best.map(|(_, trial)| trial)
}

fn through(a: &Point, b: &Point, c: &Point) -> Option<Disc> {
    let (bx, by, cx, cy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
    let twice_area = 2.0 * (bx * cy - by * cx);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let (x, y) = ((cy * b2 - by * c2) / twice_area, (bx * c2 - cx * b2) / twice_area);
    let trial = Disc {
        x: a.x + x,
        y: a.y + y,
        radius: x.hypot(y),
    };
    (trial.x.is_finite() && trial.y.is_finite()).then_some(trial)
}

/// A step of Gauss and Newton on the distances; `None` where the points do not hold the circle.
fn step(points: &[Point], circle: &Disc, radius: Option<f64>, weigh: impl Fn(&Point) -> f64) -> Option<Disc> {
    let (mut xx, mut xy, mut yy, mut x1, mut y1, mut one) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut xr, mut yr, mut r) = (0.0, 0.0, 0.0);
    for point in points {
        let weight = point.weight * weigh(point) / (point.scale * point.scale);
        if weight <= 0.0 {
            continue;
        }
        let (dx, dy) = (point.x - circle.x, point.y - circle.y);
        let distance = length(dx, dy).max(f64::MIN_POSITIVE);
        let (nx, ny, away) = (dx / distance, dy / distance, distance - circle.radius);
        xx += weight * nx * nx;
        xy += weight * nx * ny;
        yy += weight * ny * ny;
        x1 += weight * nx;
        y1 += weight * ny;
        one += weight;
        xr += weight * nx * away;
        yr += weight * ny * away;
        r += weight * away;
    }
    if one <= 0.0 {
        return None;
    }
    if radius.is_none() {
        // the radius is eliminated
        xx -= x1 * x1 / one;
        xy -= x1 * y1 / one;
        yy -= y1 * y1 / one;
        xr -= x1 * r / one;
        yr -= y1 * r / one;
    }
    let determinant = xx * yy - xy * xy;
    /// What an arc must hold the centre by, beside a whole circle: 1/4.
    const LEAST_HOLD: f64 = 1e-3;
    if determinant <= LEAST_HOLD * one * one {
        return None;
    }
    let dx = (yy * xr - xy * yr) / determinant;
    let dy = (xx * yr - xy * xr) / determinant;
    let grown = if radius.is_none() {
        (r - x1 * dx - y1 * dy) / one
    } else {
        0.0
    };
    Some(Disc {
        x: circle.x + dx,
        y: circle.y + dy,
        radius: circle.radius + grown,
    })
}

/// Takes off what lies beside an arc of points that are not of the circle.
fn leave_wrong_arcs_out(points: &mut [Point], circle: &Disc, outside: f64) {
    let count = points.len();
    let wrong = |point: &Point| point.weight <= 0.0 || point.away(circle).abs() > outside;
    let wrongs: Vec<bool> = points.iter().map(wrong).collect();
    /// Points of a turn that make a wrong arc, and points beside it that go with it.
    const ARC: usize = 40;
    let (long, beside) = ((count / ARC).max(2), (count / ARC).max(2));
    for start in 0..count {
        if (0..long).all(|k| wrongs[(start + k) % count]) {
            for at in start + count - beside..start + count + long + beside {
                points[at % count].weight = 0.0;
            }
        }
    }
}

/// The median; `None` of none.
pub(super) fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    crate::distributions::median(&mut values)
}
