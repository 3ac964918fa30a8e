//! Computes the log densities of several rebounds side by side, where they are all but normal in x.
//!
//! The place of each bell is found by as many steps for all, and each node of a rule is taken of all rebounds before the
//! next: what a rebound by itself waits for, others fill.

use pulp::{Arch, Simd, WithSimd};

use super::{Bell, Convolved, Curve, TowardsBell, BELL_STEPS, CLEAR};
use crate::exponential::{is_fused, logarithm};
use crate::model::likelihood::normal_nodes::{Order, TwoNoises};
use crate::model::likelihood::run_density::Spreads;
use crate::model::likelihood::tails::Tails;

/// Rebounds of one call.
pub(in crate::model::likelihood) const MOST_REBOUNDS: usize = 64;

/// Rebounds are computed in multiples of this.
const LANES: usize = 8;

/// A number of each of these rebounds.
type Column = [f64; MOST_REBOUNDS];

/// Log densities of up to [`MOST_REBOUNDS`] rebounds, by their restitution and the r they keep on average, under normal noise;
/// `None` where one is not all but normal in x, which [`super::ln_density`] computes.
pub(in crate::model::likelihood) fn ln_densities(
    [restitutions, kept]: [&[f64]; 2],
    spreads: Spreads,
    to: &mut [Option<Convolved>],
) {
    Arch::new().dispatch(Rebounds {
        restitutions,
        kept,
        spreads,
        to,
    });
}

struct Rebounds<'n, 'm> {
    restitutions: &'n [f64],
    kept: &'n [f64],
    spreads: Spreads,
    to: &'m mut [Option<Convolved>],
}

impl WithSimd for Rebounds<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let fused = is_fused::<S>();
        let Rebounds {
            restitutions,
            kept,
            spreads,
            to,
        } = self;
        let any = Curve::new(Tails::Normal, 0.0, 0.0, spreads);
        let curve = |restitution: f64, r: f64| Curve { restitution, r, ..any };
        let [mut x, mut step, mut variance, mut reference] = [[0.0; MOST_REBOUNDS]; 4];
        let seen = restitutions.iter().zip(kept);
        let columns = x.iter_mut().zip(&mut step).zip(variance.iter_mut().zip(&mut reference));
        for (((x, step), (variance, reference)), (e, r)) in columns.zip(seen.clone()) {
            let curve = curve(*e, *r);
            let mut place = *e;
            let mut towards = curve.towards_bell(place);
            for _ in 1..BELL_STEPS {
                place = if towards.is_near() { place } else { place + towards.step };
                towards = curve.towards_bell(place);
            }
            (*x, *step, *variance, *reference) = (place, towards.step, towards.variance, towards.reference);
        }
        let mut groups = [Order::Eight, Order::Sixteen].map(Group::new);
        for (place, (e, r)) in seen.enumerate() {
            to[place] = None;
            let towards = TowardsBell {
                step: step[place],
                variance: variance[place],
                reference: reference[place],
            };
            if *e < CLEAR || !towards.is_near() {
                continue;
            }
            let curve = curve(*e, *r);
            if let Some(bell) = curve.bell_at(x[place], towards) {
                let group = groups.iter_mut().find(|group| group.order == bell.order);
                group.into_iter().for_each(|group| group.push(place, &curve, bell));
            }
        }
        for group in groups.iter().filter(|group| group.count > 0) {
            let sums = group.sums(any.noises(), fused);
            group.write(&any, sums, fused, to);
        }
    }
}

/// Rebounds whose integrals take one rule.
struct Group {
    order: Order,
    count: usize,
    /// of each among all
    places: [usize; MOST_REBOUNDS],
    restitution: Column,
    kept: Column,
    x: Column,
    width: Column,
    reference: Column,
}

impl Group {
    fn new(order: Order) -> Group {
        let column = [0.0; MOST_REBOUNDS];
        Group {
            order,
            count: 0,
            places: [0; MOST_REBOUNDS],
            restitution: column,
            kept: column,
            x: column,
            width: column,
            reference: column,
        }
    }

    #[inline(always)]
    fn push(&mut self, place: usize, curve: &Curve, bell: Bell) {
        let to = self.count;
        self.places[to] = place;
        (self.restitution[to], self.kept[to]) = (curve.restitution, curve.r);
        (self.x[to], self.width[to], self.reference[to]) = (bell.x, bell.width, bell.reference);
        self.count += 1;
    }

    /// Whole registers of them; what fills the last one has no width, and is not read.
    #[inline(always)]
    fn filled(&self) -> usize {
        self.count.next_multiple_of(LANES).min(MOST_REBOUNDS)
    }

    /// The sums of the density of each.
    #[inline(always)]
    fn sums(&self, noises: TwoNoises, fused: bool) -> [Column; 4] {
        let mut sums = [[0.0; MOST_REBOUNDS]; 4];
        let filled = self.filled();
        let pairs = self.order.pairs();
        #[cfg(test)]
        crate::model::likelihood::tests::nodes::count(2 * pairs.len() * self.count);
        for [node, weight] in pairs {
            let [mass, of_r, of_energy, of_own] = sums.each_mut().map(|column| &mut column[..filled]);
            let to = mass.iter_mut().zip(of_r).zip(of_energy.iter_mut().zip(of_own));
            let seen = self.restitution[..filled].iter().zip(&self.kept);
            let bells = self.x.iter().zip(&self.width).zip(&self.reference);
            for (((restitution, r), ((x, width), reference)), ((mass, of_r), (of_energy, of_own))) in
                seen.zip(bells).zip(to)
            {
                let noises = TwoNoises {
                    restitution: *restitution,
                    r: *r,
                    ..noises
                };
                for apart in [-width * node, width * node] {
                    let terms = noises.at(x + apart).density(width * weight, *reference, fused);
                    *mass += terms[0];
                    *of_r += terms[1];
                    *of_energy += terms[2];
                    *of_own += terms[3];
                }
            }
        }
        sums
    }

    /// Writes the log density of each where it belongs.
    #[inline(always)]
    fn write(&self, any: &Curve, sums: [Column; 4], fused: bool, to: &mut [Option<Convolved>]) {
        /// of which [`logarithm`] gives the logarithm
        const MASS: std::ops::Range<f64> = 1e-300..1e300;
        let [mass, mut of_r, mut of_energy, mut of_own] = sums;
        let filled = self.filled();
        let mut ln_mass = [0.0; MOST_REBOUNDS];
        let means = of_r.iter_mut().zip(&mut of_energy).zip(&mut of_own);
        for ((mass, ln_mass), ((of_r, of_energy), of_own)) in mass[..filled].iter().zip(&mut ln_mass).zip(means) {
            let inverse = 1.0 / mass;
            *of_r *= inverse;
            *of_energy *= inverse;
            *of_own *= inverse;
            *ln_mass = logarithm(*mass, fused);
        }
        let ln_scale = any.ln_scale();
        for (run, place) in self.places[..self.count].iter().enumerate() {
            let value = self.reference[run] + ln_mass[run] + ln_scale;
            let means = [of_r[run], of_energy[run], of_own[run]];
            to[*place] = MASS.contains(&mass[run]).then(|| any.density_of_means(value, means));
        }
    }
}
