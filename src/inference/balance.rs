//! Fits the energy balance r = e_dry² − C ρ̃ g(δ̃) − 4 L/St − κ/v², as far as its form holds them, to every rebound at once.
//!
//! The restitution is m(r), defined where the square root is not: a lucky rebound at a setting that keeps no energy on
//! average is noise, and must not bound the parameters as the square root's domain would. Each particle's k is a
//! parameter, too, held to its dry fit by one residual (k − k̂) σ/se: the dry runs enter through what they say of k.

use nalgebra::DMatrix;

use super::effective_variance::{Erring, InSpeed, OfSpeed, Weighted};
use super::information::Sums;
use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem, Stop};
use crate::physics::impact::Form;
use crate::physics::inertia::Inertia;
use crate::physics::{bridge, rebound, viscous};

/// Rebounds that share a particle and a liquid, and so the density ratio and k.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    /// index into [`Balance::dry_k`]
    pub particle: usize,
    /// ρ̃
    pub density_ratio: f64,
    /// St = this · D v
    pub stokes_factor: f64,
    /// γ/ρp, which the bridge's loss is proportional to, m³/s²; 0 where the liquid's surface tension is not known
    pub tension_over_density: f64,
    /// D of each run, m
    pub diameter: &'a [f64],
    /// δ of each run, m
    pub film: &'a [f64],
    /// v of each run, m/s
    pub impact_speed: &'a [f64],
    /// e of each run
    pub restitution: &'a [f64],
}

/// The balance to be fitted.
///
/// Parameters: L unless there is no viscous loss, then C unless there is no inertia, then δ̃0 where the form has one, then k
/// of each particle.
#[derive(Debug, Clone)]
pub struct Balance<'a> {
    /// every rebound
    pub blocks: &'a [Block<'a>],
    /// the terms it holds
    pub form: Form,
    /// k of each particle from its dry runs, with its standard error
    pub dry_k: &'a [(f64, f64)],
    /// spread of the restitutions, to weigh the dry runs' k against them
    pub spread: f64,
}

/// What one rebound says about a point.
#[derive(Debug, Clone, Copy)]
pub struct Rebound<'a> {
    /// r, the energy kept
    pub kept: f64,
    /// m(r) less the restitution
    pub residual: f64,
    /// slopes of m(r), each with its parameter's place: k, then L, C and δ̃0 as far as the form has them
    pub slopes: &'a [(usize, f64)],
}

/// What one run contributes.
struct Terms {
    kept: f64,
    inverse_stokes: f64,
    density_ratio: f64,
    film_ratio: f64,
    shape: f64,
    particle: usize,
    dry_slope: f64,
    restitution: f64,
}

/// Remembers the last answer of a function.
#[derive(Default)]
struct Last<T>(Option<(f64, T)>);

impl<T: Copy> Last<T> {
    fn of(&mut self, x: f64, function: impl Fn(f64) -> T) -> T {
        match self.0 {
            Some((same, value)) if same == x => value,
            _ => self.0.insert((x, function(x))).1,
        }
    }
}

impl Balance<'_> {
    /// The names of the parameters before the k, in order.
    pub fn names(&self) -> &'static [&'static str] {
        const ALL: &[&str] = &["lubrication_log", "inertial_prefactor", "film_scale"];
        let inertia = self.form.inertia;
        let last = match (inertia, inertia.has_film_scale()) {
            (Inertia::None, _) => 1,
            (_, false) => 2,
            (_, true) => 3,
        };
        &ALL[self.first()..last]
    }

    /// Place of the first parameter among L, C and δ̃0.
    fn first(&self) -> usize {
        usize::from(!self.form.viscous)
    }

    /// L, C, δ̃0 and the k of a parameter vector; what the form lacks gets a value that is not read.
    pub fn unpack<'b>(&self, b: &'b [f64]) -> (f64, f64, f64, &'b [f64]) {
        let (wet, dry) = b.split_at(self.names().len());
        let place = |j: usize| j.checked_sub(self.first());
        let at = |j: usize, other: f64| place(j).and_then(|j| wet.get(j)).copied().unwrap_or(other);
        (at(0, 0.0), at(1, 0.0), at(2, 1.0), dry)
    }

    fn rebounds(&self) -> usize {
        self.blocks.iter().map(|block| block.restitution.len()).sum()
    }

    /// Every run's terms, in order.
    fn terms<'s>(&'s self, (l, c, scale, dry_k): (f64, f64, f64, &'s [f64])) -> impl Iterator<Item = Terms> + 's {
        self.blocks.iter().flat_map(move |block| {
            let k = dry_k[block.particle];
            // runs come in blocks of one speed and film: powers and exponentials are taken once for each
            let mut dry = Last::default();
            let mut shape = Last::default();
            (0..block.restitution.len()).map(move |run| {
                let v = block.impact_speed[run];
                let inverse_stokes = 1.0 / (block.stokes_factor * block.diameter[run] * v);
                let film_ratio = block.film[run] / block.diameter[run];
                let law = self.form.dry;
                let (e_dry, dry_slope) = dry.of(self.form.dry_speed.of(v), |v| {
                    (law.restitution(k, v), law.slope_dry_k(k, v))
                });
                let shape = shape.of(film_ratio, |ratio| self.form.inertia.shape(ratio, scale));
                let inertial = c * block.density_ratio * shape;
                let mut kept = e_dry * e_dry - inertial - viscous::loss(l, 1.0 / inverse_stokes);
                if self.form.bridge {
                    let kappa = bridge::kappa(block.tension_over_density, 1.0, block.diameter[run], block.film[run]);
                    kept -= bridge::loss(kappa, v);
                }
                Terms {
                    kept,
                    inverse_stokes,
                    density_ratio: block.density_ratio,
                    film_ratio,
                    shape,
                    particle: block.particle,
                    dry_slope: 2.0 * e_dry * dry_slope,
                    restitution: block.restitution[run],
                }
            })
        })
    }

    /// Slopes of r in L, C and δ̃0.
    fn slopes(&self, c: f64, scale: f64, terms: &Terms) -> [f64; 3] {
        [
            -viscous::slope_lubrication_log(1.0 / terms.inverse_stokes),
            -terms.density_ratio * terms.shape,
            -c * terms.density_ratio * self.form.inertia.slope_film_scale(terms.film_ratio, scale),
        ]
    }

    /// Two starting points: the best straight line through e² over a grid of film scales, and the same with L lowered
    /// until every rebound keeps energy. A run near r = 0 can hold a fit on its own side of the turn.
    fn starts(&self) -> [Vec<f64>; 2] {
        const SCALES: [f64; 6] = [0.01, 0.025, 0.05, 0.1, 0.2, 0.5];
        const KEPT: f64 = 0.02;
        let scales = if self.form.inertia.has_film_scale() {
            &SCALES[..]
        } else {
            &SCALES[..1]
        };
        let dry: Vec<f64> = self.dry_k.iter().map(|(k, _)| *k).collect();
        let mut best = ([0.0; 3], f64::INFINITY);
        for &scale in scales {
            let (l, c, rest) = self.line(scale, &dry);
            if rest < best.1 {
                best = ([l, c, scale], rest);
            }
        }
        let [l, c, scale] = best.0;
        let room = self
            .terms((0.0, c, scale, &dry))
            .map(|t| (t.kept - KEPT) / viscous::slope_lubrication_log(1.0 / t.inverse_stokes));
        let lowered = room.fold(l, f64::min);
        [l, lowered].map(|l| {
            let wet = [l, c, scale].into_iter().skip(self.first()).take(self.names().len());
            wet.chain(dry.iter().copied()).collect()
        })
    }

    /// L and C of the line through e² at a film scale, with its residual sum of squares.
    fn line(&self, scale: f64, dry: &[f64]) -> (f64, f64, f64) {
        let (mut xx, mut xz, mut zz, mut xy, mut zy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for t in self.terms((0.0, 0.0, scale, dry)) {
            let [x, z, _] = self.slopes(0.0, scale, &t);
            let y = t.restitution * t.restitution - t.kept;
            xx += x * x;
            xz += x * z;
            zz += z * z;
            xy += x * y;
            zy += z * y;
            yy += y * y;
        }
        let determinant = xx * zz - xz * xz;
        // one film ratio and one density ratio, say: the line cannot tell the two apart, nor need a start
        let (l, c) = if !self.form.viscous {
            (0.0, if zz > 0.0 { zy / zz } else { 0.0 })
        } else if self.form.inertia == Inertia::None || determinant <= 1e-12 * xx * zz {
            (xy / xx, 0.0)
        } else {
            ((xy * zz - zy * xz) / determinant, (zy * xx - xy * xz) / determinant)
        };
        (l, c, yy - l * xy - c * zy)
    }

    /// What every rebound says of the parameters about `b`; what the dry runs say of k is not in it.
    pub fn sums(&self, b: &[f64]) -> Sums {
        let mut sums = Sums::new(self.names().len(), self.dry_k.len());
        self.each(b, |rebound| sums.add(rebound.residual, rebound.slopes));
        sums
    }

    /// Tells of every rebound in turn, in the order of the blocks, about `b`.
    pub fn each(&self, b: &[f64], mut tell: impl FnMut(Rebound)) {
        let unpacked = self.unpack(b);
        let wet = self.names().len();
        for t in self.terms(unpacked) {
            let root = rebound::slope_mean_restitution(t.kept);
            let common = self.slopes(unpacked.1, unpacked.2, &t);
            let mut slopes = [(wet + t.particle, root * t.dry_slope); 4];
            for (j, slope) in common.iter().skip(self.first()).enumerate().take(wet) {
                slopes[j + 1] = (j, root * slope);
            }
            tell(Rebound {
                kept: t.kept,
                residual: rebound::mean_restitution(t.kept) - t.restitution,
                slopes: &slopes[..=wet],
            });
        }
    }

    /// Restitution the fitted balance gives each run, in the order of the blocks.
    pub fn fitted(&self, b: &[f64]) -> Vec<f64> {
        self.terms(self.unpack(b))
            .map(|t| rebound::mean_restitution(t.kept))
            .collect()
    }
}

impl ResidualProblem for Balance<'_> {
    fn parameters(&self) -> usize {
        self.names().len() + self.dry_k.len()
    }
    fn runs(&self) -> usize {
        self.rebounds() + self.dry_k.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        let unpacked = self.unpack(b);
        if unpacked.2 <= 0.0 {
            return Err(OutOfDomain);
        }
        let (wet, dry) = residuals.split_at_mut(self.rebounds());
        for (residual, t) in wet.iter_mut().zip(self.terms(unpacked)) {
            *residual = rebound::mean_restitution(t.kept) - t.restitution;
        }
        for ((residual, k), (own, se)) in dry.iter_mut().zip(unpacked.3).zip(self.dry_k) {
            *residual = (k - own) * self.spread / se;
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let unpacked = self.unpack(b);
        let wet = self.names().len();
        jacobian.fill(0.0);
        for (run, t) in self.terms(unpacked).enumerate() {
            let root = rebound::slope_mean_restitution(t.kept);
            let slopes = self.slopes(unpacked.1, unpacked.2, &t);
            for (j, slope) in slopes.iter().skip(self.first()).take(wet).enumerate() {
                jacobian[(run, j)] = root * slope;
            }
            jacobian[(run, wet + t.particle)] = root * t.dry_slope;
        }
        let rebounds = self.rebounds();
        for (particle, (_, se)) in self.dry_k.iter().enumerate() {
            jacobian[(rebounds + particle, wet + particle)] = self.spread / se;
        }
        Ok(())
    }
    fn scale(&self) -> f64 {
        1.0
    }
}

/// Share of its speed by which a run is moved each way: a difference then errs by 1e-8 of a slope, and by as much of a
/// bend in rounding.
const STEP: f64 = 1e-4;

impl OfSpeed for Balance<'_> {
    fn in_speed(&self, b: &[f64], erring: &Erring) -> Result<InSpeed, OutOfDomain> {
        let at = |step: f64| {
            let moved = |block: &Block| block.impact_speed.iter().map(|v| v * (1.0 + step)).collect();
            let speeds: Vec<Vec<f64>> = self.blocks.iter().map(moved).collect();
            let blocks: Vec<Block> = self
                .blocks
                .iter()
                .zip(&speeds)
                .map(|(block, impact_speed)| Block { impact_speed, ..*block })
                .collect();
            let balance = Balance {
                blocks: &blocks,
                ..self.clone()
            };
            let mut jacobian = DMatrix::zeros(self.runs(), self.parameters());
            balance.jacobian(b, &mut jacobian)?;
            Ok((balance.fitted(b), jacobian))
        };
        let ((less, of_less), (here, jacobian), (more, of_more)) = (at(-STEP)?, at(0.0)?, at(STEP)?);
        let mut jacobian_slope = of_more - of_less;
        let (mut slope, mut bend) = (vec![0.0; here.len()], vec![0.0; here.len()]);
        for (run, v) in erring.speed.iter().enumerate() {
            let step = STEP * v;
            slope[run] = (more[run] - less[run]) / (2.0 * step);
            bend[run] = (more[run] - 2.0 * here[run] + less[run]) / (step * step);
            jacobian_slope.row_mut(run).scale_mut(0.5 / step);
        }
        Ok(InSpeed {
            value: here,
            slope,
            bend,
            jacobian,
            jacobian_slope,
        })
    }
}

/// Fits the balance again from where a fit of nearly the same balance ended, its residuals times these roots of weights.
pub fn refit_balance(balance: &Balance, roots: &[f64], near: &[f64]) -> Fit {
    let problem = Weighted {
        problem: balance,
        roots,
    };
    fit(&problem, near)
}

/// Fits the balance; no starting values asked.
pub fn fit_balance(balance: &Balance) -> Fit {
    let [line, lowered] = balance.starts();
    let first = fit(balance, &line);
    if lowered == line {
        return first;
    }
    let second = fit(balance, &lowered);
    let rank = |fit: &Fit| (fit.stop != Stop::Converged, fit.residual_sum_of_squares);
    if rank(&second) < rank(&first) {
        second
    } else {
        first
    }
}
