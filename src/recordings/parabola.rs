//! Fits a parabola through frames of a track, and says what it shows.

/// What a segment shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// a sphere that falls or rises freely
    Flight,
    /// a sphere at one height
    Rest,
    /// neither: in the film, in a hand, too short to tell
    Other,
}

/// Fewer frames are no flight.
pub(super) const LEAST_FRAMES: usize = 5;

/// Standard deviations that a movement must exceed to be one.
const SURE: f64 = 4.0;

/// y = c + u (t − t̄) + a ((t − t̄)² − m₂)/2 by least squares, t̄ and m₂ being the mean and variance of the times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parabola {
    /// t̄
    pub time: f64,
    /// m₂
    pub spread: f64,
    /// c, the mean height
    pub mean: f64,
    /// u, by a straight line
    pub slope: f64,
    /// what u has to change by with a: −Σ (t − t̄)³/2 Σ (t − t̄)²
    pub skew: f64,
    /// Σ (t − t̄)²
    pub sum_of_squares: f64,
    /// Σ q², q being ((t − t̄)² − m₂)/2 without its part along t − t̄
    pub of_acceleration: f64,
    /// Σ q y
    pub with_heights: f64,
    /// Σ (y − the parabola)²
    pub squares: f64,
    pub frames: usize,
    /// first and last time
    pub ends: [f64; 2],
}

impl Parabola {
    /// Through points of a time and a height; `None` of none.
    pub fn through(points: &[(f64, f64)]) -> Option<Parabola> {
        let count = points.len() as f64;
        let ends = [points.first()?.0, points.last()?.0];
        let time = points.iter().map(|(t, _)| t).sum::<f64>() / count;
        let mean = points.iter().map(|(_, y)| y).sum::<f64>() / count;
        let (mut second, mut third, mut straight) = (0.0, 0.0, 0.0);
        for (t, y) in points {
            let x = t - time;
            second += x * x;
            third += x * x * x;
            straight += x * (y - mean);
        }
        let share = |sum: f64| if second > 0.0 { sum / second } else { 0.0 };
        let (spread, skew, slope) = (second / count, -0.5 * share(third), share(straight));
        let mut found = Parabola {
            time,
            spread,
            mean,
            slope,
            skew,
            sum_of_squares: second,
            of_acceleration: 0.0,
            with_heights: 0.0,
            squares: 0.0,
            frames: points.len(),
            ends,
        };
        for (t, y) in points {
            let q = found.bend_at(*t);
            found.of_acceleration += q * q;
            found.with_heights += q * (y - mean);
        }
        let acceleration = found.acceleration();
        found.squares = points
            .iter()
            .map(|(t, y)| y - found.height_under(acceleration, *t))
            .map(|residual| residual * residual)
            .sum();
        Some(found)
    }

    /// q at a time.
    fn bend_at(&self, t: f64) -> f64 {
        let x = t - self.time;
        0.5 * (x * x - self.spread) + self.skew * x
    }

    /// a, its own; 0 of fewer than three frames.
    pub fn acceleration(&self) -> f64 {
        if self.frames < 3 || self.of_acceleration <= 0.0 {
            return 0.0;
        }
        self.with_heights / self.of_acceleration
    }

    /// The gravity of a flight by itself with its standard error, where positions scatter by σ.
    pub fn own_gravity(&self, sigma: f64) -> [f64; 2] {
        [-self.acceleration(), sigma / self.of_acceleration.sqrt()]
    }

    /// Height at a time with this acceleration.
    pub fn height_under(&self, acceleration: f64, t: f64) -> f64 {
        self.mean + self.slope * (t - self.time) + acceleration * self.bend_at(t)
    }

    /// Velocity at a time with this acceleration.
    pub fn velocity_under(&self, acceleration: f64, t: f64) -> f64 {
        self.slope + acceleration * (t - self.time + self.skew)
    }

    /// By what height and velocity at a time change with g.
    pub fn by_gravity(&self, t: f64) -> [f64; 2] {
        [
            self.height_under(-1.0, t) - self.height_under(0.0, t),
            self.velocity_under(-1.0, t) - self.velocity_under(0.0, t),
        ]
    }

    /// Σ (y − the parabola)² with this acceleration.
    pub fn squares_under(&self, acceleration: f64) -> f64 {
        let off = acceleration - self.acceleration();
        self.squares + off * off * self.of_acceleration
    }

    pub fn height(&self, t: f64) -> f64 {
        self.height_under(self.acceleration(), t)
    }

    pub fn velocity(&self, t: f64) -> f64 {
        self.velocity_under(self.acceleration(), t)
    }

    /// Standard deviation of a position that scatters by σ about it at a time, before its acceleration is known.
    pub fn position_sd(&self, t: f64, sigma: f64) -> f64 {
        let share = |of: f64, sum: f64| if sum > 0.0 { of * of / sum } else { 0.0 };
        let straight = share(t - self.time, self.sum_of_squares);
        let bent = share(self.bend_at(t), self.of_acceleration);
        sigma * (1.0 + 1.0 / self.frames as f64 + straight + bent).sqrt()
    }

    /// The larger speed of both ends.
    pub fn fastest(&self) -> f64 {
        self.ends
            .map(|t| self.velocity(t).abs())
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// How far it bends upwards, in the unit of the scatter of positions.
    pub fn bend(&self) -> f64 {
        self.acceleration() * self.of_acceleration.sqrt()
    }

    /// Whether it surely bends upwards where positions scatter by σ.
    pub fn bends_upwards(&self, sigma: f64) -> bool {
        self.frames >= LEAST_FRAMES && self.bend() > SURE * sigma
    }

    /// Whether it surely bends downwards.
    pub fn bends_downwards(&self, sigma: f64) -> bool {
        self.frames >= LEAST_FRAMES && -self.bend() > SURE * sigma
    }

    /// What it is beside the parabola of a fall, where positions scatter by σ. A fall is accelerated as that one is, and what
    /// hardly moves beside it rests, whatever so little is.
    pub fn kind_beside(&self, fall: &Parabola, sigma: f64) -> Kind {
        /// of the acceleration, that a short flight's may be off by
        const NEAR: f64 = 0.3;
        /// of the fastest speed
        const CREEPING: f64 = 0.02;
        if self.frames < LEAST_FRAMES {
            return Kind::Other;
        }
        let off = (self.acceleration() - fall.acceleration()).abs();
        let se = sigma / self.of_acceleration.sqrt();
        if self.bends_downwards(sigma) && off < NEAR * fall.acceleration().abs() + SURE * se {
            return Kind::Flight;
        }
        let moved = self.slope.abs() * self.sum_of_squares.sqrt();
        let still = moved < SURE * sigma && !self.bends_upwards(sigma) && !self.bends_downwards(sigma);
        if still || self.fastest() < CREEPING * fall.fastest() {
            return Kind::Rest;
        }
        Kind::Other
    }
}

/// Sums of a part that grows frame by frame, about its first frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments {
    start: f64,
    first: f64,
    unit: f64,
    count: f64,
    /// Σ xⁿ, n from 1
    powers: [f64; 4],
    /// Σ xⁿ y, n from 0
    heights: [f64; 3],
    height_squares: f64,
}

impl Moments {
    /// Of nothing yet; times are counted from the first, in a unit.
    pub fn new(start: f64, first: f64, unit: f64) -> Moments {
        Moments {
            start,
            first,
            unit,
            count: 0.0,
            powers: [0.0; 4],
            heights: [0.0; 3],
            height_squares: 0.0,
        }
    }

    pub fn add(&mut self, t: f64, y: f64) {
        let (x, y) = ((t - self.start) / self.unit, y - self.first);
        let square = x * x;
        self.count += 1.0;
        for (sum, power) in self.powers.iter_mut().zip([x, square, square * x, square * square]) {
            *sum += power;
        }
        for (sum, power) in self.heights.iter_mut().zip([1.0, x, square]) {
            *sum += power * y;
        }
        self.height_squares += y * y;
    }

    /// Σ (y − the parabola through all)².
    pub fn squares(&self) -> f64 {
        if self.count <= 3.0 {
            return 0.0;
        }
        let [s1, s2, s3, s4] = self.powers;
        let [h0, h1, h2] = self.heights;
        let n = self.count;
        // x and x² less their means, then x² less its part along x
        let (c11, c12, c22) = (s2 - s1 * s1 / n, s3 - s1 * s2 / n, s4 - s2 * s2 / n);
        let (b1, b2) = (h1 - s1 * h0 / n, h2 - s2 * h0 / n);
        let along = c12 / c11;
        let (left, with) = (c22 - along * c12, b2 - along * b1);
        let squares = self.height_squares - h0 * h0 / n - b1 * b1 / c11 - with * with / left;
        squares.max(0.0)
    }
}
