//! Chooses the nodes of an integral over the hidden number.
//!
//! Most integrands are all but normal: a Gauss–Hermite rule does, about where they are largest, and its last coefficients say
//! whether it did. Where it did not, Gauss's rule on panels that are short beside whatever is narrow there. The line is gone
//! along in z, or where the r of a setting has its zero within reach in x with r(z) = m⁻¹(x) to first order, which makes m(r) as
//! smooth as the rest; where several settings turn, from each of them half the way to the next.

use super::at_nodes::{Path, RuleNodes};
use super::gauss::{has_converged, GAUSS, HERMITE, HERMITE_NODES};
use super::{AtNodes, Hidden, SettingRuns, Sums, FALL, MOST_NODES, REACH};
use crate::model::likelihood::run_density::Seen;
use crate::model::likelihood::run_noise::{MeasuredRun, RunNoise};
use crate::model::likelihood::tails::Tails;
use crate::physics::rebound::mean_and_slope;
use crate::roots::root_between;

/// Panels beyond which parameters are taken to have no density.
const MOST_PANELS: usize = 20_000;

/// Standard deviations of whatever is narrow that a panel is long: Gauss's rule of order 12 has 1e-9 of a normal density over so
/// many; Student's has a pole about one from the line.
const NORMAL: f64 = 5.0;
const STUDENT: f64 = 1.5;

/// A place of a bell and its width, in the variable of a path.
#[derive(Debug, Clone, Copy)]
struct Bell {
    x: f64,
    width: f64,
}

/// A panel between two places of a path, with the logarithm of the integrand at both.
struct Panel {
    path: Path,
    ends: [f64; 2],
    ln: [f64; 2],
}

/// Panels of the whole line.
struct Panels {
    all: Vec<Panel>,
    /// the largest logarithm that is known
    best: f64,
    /// z of nought and of the turns: farther out the logarithm has one largest value at most
    within: [f64; 2],
}

impl Panels {
    /// Adds those between places that follow one another.
    fn add(&mut self, path: Path, places: &[f64], heights: &[f64]) {
        for (ends, ln) in places.windows(2).zip(heights.windows(2)) {
            self.best = self.best.max(ln[0]).max(ln[1]);
            self.all.push(Panel {
                path,
                ends: [ends[0].min(ends[1]), ends[0].max(ends[1])],
                ln: [ln[0], ln[1]],
            });
        }
    }
}

impl SettingRuns<'_> {
    /// The path about a z.
    fn turn_path(&self, z: f64) -> Path {
        let slope = self.kept_slope(z);
        Path::Turn {
            kept: self.kept(z) - slope * z,
            slope,
        }
    }

    /// z where r is zero within reach.
    fn turn(&self, reach: f64) -> Option<f64> {
        root_between([-reach, reach], |z| self.kept(z))
    }
}

impl Hidden<'_> {
    /// Writes the integral to the sums where the integrand is all but normal; else false, and what the sums hold is nothing.
    pub(super) fn over_bell(&self, sums: &mut Sums) -> bool {
        // Student's tails fall too slowly for what the last coefficients say
        if self.noise.tails != Tails::Normal {
            return false;
        }
        if self.over_bell_of(Path::Straight, sums) {
            return true;
        }
        let [setting] = self.settings else {
            return false;
        };
        let turn = setting.turn(REACH);
        turn.is_some_and(|z| self.over_bell_of(setting.turn_path(z), sums))
    }

    /// The same along a path.
    fn over_bell_of(&self, path: Path, sums: &mut Sums) -> bool {
        /// of the place of a bell and its width
        const STEPS: usize = 5;
        /// of a step, in widths, and of the ratio of two widths: what follows is as good as it gets
        const NEAR: f64 = 0.2;
        let mut bell = self.start(path);
        for _ in 0..STEPS {
            if !bell.is_clear(path) {
                return false;
            }
            sums.clear();
            self.at_hermite(path, bell, sums);
            if has_converged(sums.nodes.parts.as_chunks().0) && keeps_its_sign(sums) {
                return true;
            }
            let Some((step, ratio)) = bell.towards(&sums.nodes) else {
                return false;
            };
            bell.x += step * bell.width;
            bell.width *= ratio;
            if step.abs() < NEAR && (ratio - 1.0).abs() < NEAR {
                return false;
            }
        }
        false
    }

    /// Where an integrand may be largest along a path.
    fn start(&self, path: Path) -> Bell {
        let Path::Turn { kept, slope } = path else {
            return Bell { x: 0.0, width: 1.0 };
        };
        let run = &self.settings[0].runs[0];
        // a step of Gauss–Newton's from the restitution, or from where z is nought: the rest is found by the nodes themselves
        let (e, own) = match run.seen {
            Seen::Rebound(e) => (e, 1.0 / run.errors.variance(self.noise.sigma)),
            Seen::On(..) | Seen::Measured(..) => (path.place(0.0), 0.0),
        };
        // far from the turn m⁻¹(x) is x |x|, and near it there is no bell
        let (z, of_z) = ((e * e.abs() - kept) / slope, 2.0 * e.abs() / slope);
        let variance = 1.0 / (own + of_z * of_z);
        Bell {
            x: e - z * of_z * variance,
            width: variance.sqrt(),
        }
    }

    fn at_hermite(&self, path: Path, Bell { x, width }: Bell, sums: &mut Sums) {
        let mut nodes = RuleNodes::along(path);
        for [node, weight, _] in HERMITE {
            nodes.push(x - width * node, width * weight);
            nodes.push(x + width * node, width * weight);
        }
        self.at_nodes(&mut nodes, sums);
    }

    /// Writes the integral to the sums, by panels along the whole line as far as there is something; `None` where there is no
    /// end of them.
    pub(super) fn over_panels(&self, sums: &mut Sums) -> Option<()> {
        /// of the way from nought to a turn
        const PLACES: usize = 8;
        let far = |ln: f64| (2.0 * (FALL + self.largest() - ln)).max(0.0).sqrt();
        let mut places = vec![0.0];
        for (turn, _) in self.turns(far(self.ln_at(&places, sums)[0])) {
            places.extend((1..=PLACES).map(|place| turn * place as f64 / PLACES as f64));
        }
        let best = self.ln_at(&places, sums).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let far = far(best);
        let turns = self.turns(far);
        let mut segments = vec![];
        for (place, (z, setting)) in turns.iter().enumerate() {
            let half_way = |other: &(f64, usize)| 0.5 * (z + other.0);
            let before = place.checked_sub(1).map_or(-far, |before| half_way(&turns[before]));
            let after = turns.get(place + 1).map_or(far, half_way);
            segments.push((self.settings[*setting].turn_path(*z), [before, after]));
        }
        if turns.is_empty() {
            segments.push((Path::Straight, [-far, far]));
        }
        let mut panels = Panels {
            all: vec![],
            best,
            within: turns
                .iter()
                .fold([0.0; 2], |[lo, hi]: [f64; 2], (z, _)| [lo.min(*z), hi.max(*z)]),
        };
        for (path, ends) in segments {
            let mut ends = ends.map(|z| path.place(z));
            ends.sort_by(f64::total_cmp);
            self.panels_of(path, ends, sums, &mut panels)?;
        }
        let Panels { all: panels, best, .. } = panels;
        sums.clear();
        sums.reference = best;
        let mut nodes = RuleNodes::along(Path::Straight);
        for Panel { path, ends, ln } in panels {
            if ln.iter().all(|ln| *ln < best - FALL) {
                continue;
            }
            for_nodes_of_panel(ends, |x, weight| {
                if nodes.is_full() || nodes.path != path {
                    self.at_nodes(&mut nodes, sums);
                    nodes = RuleNodes::along(path);
                }
                nodes.push(x, weight);
            });
        }
        self.at_nodes(&mut nodes, sums);
        Some(())
    }

    /// Adds panels between two places, from the turn outwards until there is nothing and less follows; `None` where there is no end of them.
    fn panels_of(&self, path: Path, [lo, hi]: [f64; 2], sums: &mut Sums, to: &mut Panels) -> Option<()> {
        if lo.is_nan() || hi.is_nan() {
            return None;
        }
        let inner = 0f64.clamp(lo, hi.max(lo));
        let widths = match self.noise.tails {
            Tails::Normal => NORMAL,
            _ => STUDENT,
        };
        let longest = |x: f64| widths / self.narrowness(path, x);
        for end in [lo, hi] {
            let mut places = vec![inner];
            let mut is_done = inner == end;
            while !is_done {
                while places.len() < MOST_NODES && !is_done {
                    let from = places[places.len() - 1];
                    let (rest, sign) = ((end - from).abs(), (end - from).signum());
                    let mut length = longest(from).min(path.longest(from)).min(rest);
                    // the width mostly falls outwards
                    length = length.min(longest(from + sign * length));
                    let next = if length < rest { from + sign * length } else { end };
                    if next.is_nan() || next == from {
                        return None;
                    }
                    places.push(next);
                    is_done = next == end;
                }
                let z: Vec<f64> = places.iter().map(|x| path.at(*x)[0]).collect();
                let heights = self.ln_at(&z, sums);
                to.add(path, &places, &heights);
                if to.all.len() > MOST_PANELS {
                    return None;
                }
                if let ([.., before, last], Some(z)) = (&heights[..], z.last()) {
                    let is_outside = *z < to.within[0] || *z > to.within[1];
                    is_done |= is_outside && *last < to.best - FALL && last < before;
                }
                places = vec![places[places.len() - 1]];
            }
        }
        Some(())
    }

    /// By how many standard deviations of whatever is narrow the integrand moves with a place.
    fn narrowness(&self, path: Path, x: f64) -> f64 {
        let [z, stretch] = path.at(x);
        let RunNoise { sigma, energy, .. } = self.noise;
        let mut squares = 1.0;
        for setting in self.settings {
            let (mean, slope) = mean_and_slope(setting.kept(z));
            let of_mean = slope * setting.kept_slope(z);
            let further = (slope * energy).powi(2);
            for run in setting.runs {
                let (moved, variance) = match run.seen {
                    Seen::Rebound(_) | Seen::Measured(..) => {
                        let ratio = run.errors.ratio(z);
                        let moved = run.errors.moved(ratio, mean, of_mean);
                        (moved, run.errors.variance(sigma * ratio) + ratio * ratio * further)
                    }
                    Seen::On(..) => (of_mean, sigma * sigma + further),
                };
                squares += moved * moved / variance;
            }
        }
        stretch * squares.sqrt()
    }

    /// Where settings turn within reach, in order, each with its setting.
    pub(super) fn turns(&self, reach: f64) -> Vec<(f64, usize)> {
        let mut turns = vec![];
        for (setting, of) in self.settings.iter().enumerate() {
            turns.extend(of.turn(reach).map(|z| (z, setting)));
        }
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        turns
    }

    /// The largest value that the logarithm of all factors but φ has.
    fn largest(&self) -> f64 {
        let of = |run: &MeasuredRun| match run.seen {
            Seen::Rebound(_) => {
                let least = run.errors.variance(self.noise.sigma * run.errors.ratio(-REACH));
                self.noise.tails.ln_density(0.0).value - 0.5 * least.max(f64::MIN_POSITIVE).ln()
            }
            Seen::On(..) | Seen::Measured(..) => 0.0,
        };
        self.runs().map(of).sum()
    }
}

impl Bell {
    /// Whether the turn is far beside the width.
    fn is_clear(&self, path: Path) -> bool {
        /// widths beyond which a bell has nothing
        const FAR: f64 = 6.7;
        let is_number = self.x.is_finite() && self.width.is_finite() && self.width > 0.0;
        is_number && (matches!(path, Path::Straight) || self.x.abs() > FAR * self.width)
    }

    /// A step in widths and the ratio of the widths, by the parabola through the logarithm at the innermost nodes; `None` where
    /// that has no largest value.
    fn towards(&self, at: &AtNodes) -> Option<(f64, f64)> {
        /// of a step: farther away another parabola fits
        const FARTHEST: f64 = 4.0;
        let [[a, ..], [b, ..], ..] = HERMITE;
        // with the stretch of the path, which is a factor of what is integrated
        let ln = |node: usize| at.ln[node] + at.stretch[node].ln();
        let [inner, outer] = [[ln(0), ln(1)], [ln(2), ln(3)]];
        let slope = (a * (inner[1] - inner[0]) + b * (outer[1] - outer[0])) / (2.0 * (a * a + b * b));
        let bend = (inner[0] + inner[1] - outer[0] - outer[1]) / (b * b - a * a);
        // nor where it is no number
        (bend > 0.0).then(|| ((slope / bend).clamp(-FARTHEST, FARTHEST), 1.0 / bend.sqrt()))
    }
}

/// Whether no setting turns within the nodes of the bell that were asked for last.
fn keeps_its_sign(sums: &Sums) -> bool {
    let ends = [HERMITE_NODES - 2, HERMITE_NODES - 1];
    // not where one is no number
    sums.at
        .iter()
        .all(|setting| ends.map(|node| setting.kept[node]).iter().product::<f64>() > 0.0)
}

/// Gives Gauss's nodes of a panel, with their weights.
fn for_nodes_of_panel([lo, hi]: [f64; 2], mut each: impl FnMut(f64, f64)) {
    let (half, middle) = (0.5 * (hi - lo), 0.5 * (lo + hi));
    for [node, weight] in GAUSS {
        for x in [middle - half * node, middle + half * node] {
            each(x, half * weight);
        }
    }
}
