//! Computes the restitution that a code's contact gives for its input, and the input for a restitution asked for.
//!
//! Symbols: e restitution, ζ damping over critical damping, m, R effective mass and radius of the contact, δ overlap,
//! κ = F/(m δ^(3/2)) of a Hertz contact. A linear spring, m δ'' + 2 ζ √(k m) δ' + k δ = 0, and a Hertz spring with damping
//! ∝ δ^(1/4), m δ'' + α √(K m) δ^(1/4) δ' + K δ^(3/2) = 0, give the same e: with s ∝ δ^(5/4) the second becomes the first in
//! the plane of speed and s, with ζ = α/√5. Source of the forms: Schwager & Pöschel 2007 (Granular Matter 9, 465);
//! Antypov & Elliott 2011 (EPL 94, 50004).

use std::f64::consts::PI;

use crate::roots::root_between;

/// Where a code ends a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// where the overlap ends: the damping may pull before
    Overlap,
    /// where the force would turn to pulling
    Force,
}

/// −ln e of a contact that ends with its force: 2 χ/tan χ with χ = arccos ζ below critical damping, 2 ψ/tanh ψ with
/// ψ = arcosh ζ above.
fn force_ends(angle: f64, tangent: fn(f64) -> f64) -> f64 {
    if angle == 0.0 {
        2.0
    } else {
        2.0 * angle / tangent(angle)
    }
}

/// e at a share ζ ≥ 0 of critical damping; 0 where the overlap never ends.
pub(super) fn rebound(share: f64, end: End) -> f64 {
    let lost = match end {
        End::Overlap if share >= 1.0 => f64::INFINITY,
        End::Overlap => PI * share / (1.0 - share * share).sqrt(),
        End::Force if share <= 1.0 => force_ends(share.acos(), f64::tan),
        End::Force => force_ends(share.acosh(), f64::tanh),
    };
    (-lost).exp()
}

/// ζ that gives e, 0 < e ≤ 1.
pub(super) fn share_for(e: f64, end: End) -> f64 {
    let lost = -e.ln();
    match end {
        End::Overlap => lost / (PI * PI + lost * lost).sqrt(),
        // at e = 1 rounding may leave no root before the end
        End::Force if lost < 2.0 => {
            root_between([0.0, 0.5 * PI], |chi| lost - force_ends(chi, f64::tan)).map_or(0.0, f64::cos)
        }
        End::Force => root_between([0.0, 0.5 * lost], |psi| lost - force_ends(psi, f64::tanh))
            .unwrap_or(0.5 * lost)
            .cosh(),
    }
}

/// How LAMMPS' `damping tsuji` turns its number into damping.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tsuji {
    /// before the version of 2 September 2026: √2 is missing
    WithoutRootTwo,
    /// since
    WithRootTwo,
}

impl Tsuji {
    /// ζ of its number, by the polynomial of Marshall 2009, eq. 53 (LAMMPS, gran_sub_mod_damping.cpp).
    fn share(self, input: f64) -> f64 {
        const POLYNOMIAL: [f64; 7] = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
        let alpha = POLYNOMIAL.iter().rev().fold(0.0, |sum, c| sum * input + c);
        let factor: f64 = match self {
            Tsuji::WithoutRootTwo => 1.0,
            Tsuji::WithRootTwo => 2.0,
        };
        alpha * factor.sqrt() / 5f64.sqrt()
    }

    /// e that comes of its number.
    pub(super) fn rebound(self, input: f64) -> f64 {
        rebound(self.share(input), End::Overlap)
    }

    /// The number that gives e; `None` where none between 0 and 1 does.
    pub(super) fn input_for(self, e: f64) -> Option<f64> {
        root_between([0.0, 1.0], |input| self.rebound(input) - e)
    }
}

/// State of a contact in its own units: overlap, and speed over impact speed.
type State = [f64; 2];

/// One step of the fourth-order Runge–Kutta rule.
fn stepped([x, u]: State, h: f64, acceleration: &impl Fn(f64, f64) -> f64) -> State {
    let slope = |x: f64, u: f64| [u, acceleration(x, u)];
    let a = slope(x, u);
    let b = slope(x + 0.5 * h * a[0], u + 0.5 * h * a[1]);
    let c = slope(x + 0.5 * h * b[0], u + 0.5 * h * b[1]);
    let d = slope(x + h * c[0], u + h * c[1]);
    let sum = |i: usize| h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
    [x + sum(0), u + sum(1)]
}

/// Step in the contact's own time; an undamped contact lasts about 3.
const STEP: f64 = 1.0 / 512.0;

/// After this time a contact that has not ended counts as stuck.
const LONGEST: f64 = 60.0;

/// Overlap and speed below which it does, too: nothing drives it any more.
const STILL: f64 = 1e-9;

/// Changes of the sum of squares that are not followed: e to 1e-5 at one speed.
const SETTLED: f64 = 1e-10;

/// Most moves and halvings of a search; the laws in the tests take about 30.
const MOST_MOVES: usize = 100;

/// e of a contact that starts with no overlap at speed 1.
fn integrated(acceleration: impl Fn(f64, f64) -> f64, end: End) -> f64 {
    // above zero while the contact lasts; it cannot end before it turns
    let lasts = |[x, u]: State| match end {
        End::Overlap => x,
        End::Force if u < 0.0 => -acceleration(x, u),
        End::Force => 1.0,
    };
    let mut state = stepped([0.0, 1.0], STEP, &acceleration);
    for _ in 0..(LONGEST / STEP) as usize {
        let next = stepped(state, STEP, &acceleration);
        if lasts(next) <= 0.0 {
            let last = root_between([0.0, STEP], |h| lasts(stepped(state, h, &acceleration))).unwrap_or(0.0);
            return -stepped(state, last, &acceleration)[1];
        }
        if next[0].max(next[1].abs()) < STILL {
            break;
        }
        state = next;
    }
    0.0
}

/// e of x'' + a √x x' + x^(3/2) = 0: a Hertz contact with damping ∝ √δ (Brilliantov & Pöschel).
///
/// a = γ v^(1/5) κ^(-3/5) where m γ √δ is the damping coefficient.
pub(super) fn viscoelastic_rebound(damping: f64, end: End) -> f64 {
    // a step may reach below zero, where no force acts
    let root = |x: f64| x.max(0.0).sqrt();
    integrated(|x, u| -root(x) * (damping * u + x), end)
}

/// a that gives e, 0 < e < 1.
pub(super) fn viscoelastic_damping_for(e: f64, end: End) -> f64 {
    let mut most = 1.0;
    while viscoelastic_rebound(most, end) > e && most < 1e3 {
        most *= 2.0;
    }
    // an e that rounding cannot tell from 1 takes no damping
    root_between([0.0, most], |damping| viscoelastic_rebound(damping, end) - e).unwrap_or(0.0)
}

/// Keywords of LIGGGHTS' contact `hooke` with `viscous on`.
///
/// At each step its logarithm of the restitution is ln(`MaximumRestitution`) + `CriticalStokes`/St, St taken at the speed of
/// that moment and below zero while approaching (LIGGGHTS-PUBLIC 3.8.0, normal_model_hooke.h). So e is neither
/// `MaximumRestitution` · exp(−`CriticalStokes`/St) nor the law with these numbers as e_inf and St_c.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StokesKeywords {
    pub maximum_restitution: f64,
    pub critical_stokes: f64,
}

impl StokesKeywords {
    /// e at an impact's Stokes number, `limitForce` being off where the contact ends with the overlap.
    pub(super) fn rebound(&self, stokes: f64, end: End) -> f64 {
        let (log_most, ratio) = (self.maximum_restitution.ln(), self.critical_stokes / stokes);
        let damped = |u: f64| {
            // ζ u for ζ = |l|/√(l² + π²), l = ln e − ratio/u, written so that u may be zero
            let l = log_most * u - ratio;
            let size = (l * l + PI * PI * u * u).sqrt();
            if size > 0.0 {
                u * l.abs() / size
            } else {
                u
            }
        };
        integrated(|x, u| -x - 2.0 * damped(u), end)
    }

    /// The keywords whose contact lies nearest to a law, by least squares over pairs of St and e.
    pub(super) fn nearest(law: &[[f64; 2]], end: End) -> StokesKeywords {
        // in these coordinates every point is allowed: 0 < maximum < 1, critical > 0
        let keywords = |[a, b]: [f64; 2]| StokesKeywords {
            maximum_restitution: (-a.exp()).exp(),
            critical_stokes: b.exp(),
        };
        let off = |at: [f64; 2]| -> f64 {
            let contact = keywords(at);
            law.iter().map(|&[st, e]| (contact.rebound(st, end) - e).powi(2)).sum()
        };
        let lowest = law.iter().map(|[st, _]| *st).fold(f64::INFINITY, f64::min);
        let highest = law.iter().map(|[st, _]| *st).fold(0.0, f64::max);
        // a law near its threshold has a second, shallower best without St: begin where a coarse look finds the least
        let (first, last) = ((0.03 * lowest).ln(), highest.ln());
        let starts = (0..40).map(|i| {
            let maximum: f64 = [0.4, 0.6, 0.75, 0.9][i % 4];
            [(-maximum.ln()).ln(), first + (last - first) * (i / 4) as f64 / 9.0]
        });
        let tried = starts.map(|start| (off(start), start));
        let nearest = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        let (mut least, mut best) = nearest.unwrap_or((f64::INFINITY, [0.0; 2]));
        let mut reach = 0.25;
        // a compass search: no slopes, which kink where l changes its sign; a law without St has its best at infinity
        for _ in 0..MOST_MOVES {
            if reach < STEP / 64.0 {
                break;
            }
            let around = [
                [reach, 0.0],
                [-reach, 0.0],
                [0.0, reach],
                [0.0, -reach],
                [reach, -reach],
                [-reach, reach],
            ];
            let tried = around.map(|[a, b]| [best[0] + a, best[1] + b]);
            let nearer = tried
                .into_iter()
                .map(|at| (off(at), at))
                .find(|(distance, _)| *distance < least - SETTLED);
            match nearer {
                Some((distance, at)) => (least, best) = (distance, at),
                None => reach *= 0.5,
            }
        }
        keywords(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The linear contact integrated as it stands.
    fn linear(share: f64, end: End) -> f64 {
        integrated(|x, u| -x - 2.0 * share * u, end)
    }

    /// The Hertz contact with damping ∝ δ^(1/4); the root at the start costs the rule its order.
    fn hertz(alpha: f64, end: End) -> f64 {
        let quarter = |x: f64| x.max(0.0).sqrt().sqrt();
        integrated(|x, u| -alpha * quarter(x) * u - x.max(0.0).powf(1.5), end)
    }

    const ENDS: [End; 2] = [End::Overlap, End::Force];

    #[track_caller]
    fn assert_near(x: f64, expected: f64, within: f64) {
        assert!((x - expected).abs() < within, "{x} {expected}");
    }

    /// What LIGGGHTS, LAMMPS and YADE rest on: one formula for both springs, limited or not.
    #[test]
    fn the_closed_forms_are_the_integrated_contacts() {
        for end in ENDS {
            for share in [0.03, 0.2, 0.55, 0.8, 1.0, 1.3, 2.5] {
                assert_near(rebound(share, end), linear(share, end), 1e-9);
            }
            for share in [0.05, 0.3, 0.7] {
                assert_near(rebound(share, end), hertz(share * 5f64.sqrt(), end), 1e-4);
            }
        }
    }

    #[test]
    fn the_inverses_come_back() {
        for e in [0.01, 0.06, 0.1353, 0.1354, 0.42, 0.87, 0.999] {
            for end in ENDS {
                assert_near(rebound(share_for(e, end), end), e, 1e-13);
            }
            for tsuji in [Tsuji::WithoutRootTwo, Tsuji::WithRootTwo] {
                if let Some(input) = tsuji.input_for(e) {
                    assert_near(tsuji.rebound(input), e, 1e-13);
                }
            }
        }
        for e in [0.3, 0.8, 0.95] {
            for end in ENDS {
                assert_near(viscoelastic_rebound(viscoelastic_damping_for(e, end), end), e, 1e-9);
            }
        }
        assert_eq!(share_for(1.0, End::Overlap), 0.0);
        assert_near(share_for(1.0, End::Force), 0.0, 1e-15);
    }

    /// Asked .9, .7, .5, .3 a LAMMPS of 29 September 2021 gave these; with the root the polynomial is within a hundredth.
    #[test]
    fn tsuji_without_root_two_is_seen() {
        for (asked, measured) in [(0.9, 0.928), (0.7, 0.778), (0.5, 0.616), (0.3, 0.440)] {
            assert_near(Tsuji::WithoutRootTwo.rebound(asked), measured, 1e-3);
            assert_near(Tsuji::WithRootTwo.rebound(asked), asked, 0.01);
            assert!((Tsuji::WithoutRootTwo.rebound(asked) - asked).abs() > 0.02, "{asked}");
        }
        // what cannot be had is told
        assert!(Tsuji::WithoutRootTwo.input_for(0.1).is_none() && Tsuji::WithRootTwo.input_for(0.1).is_some());
    }

    /// 1 − C₁ a′ + C₂ a′² with C₂ = (3/5) C₁², the dry law's own series (Ramírez et al. 1999).
    #[test]
    fn the_viscoelastic_contact_has_the_series_of_the_dry_law() {
        let second = |damping: f64| {
            let lost = 1.0 - viscoelastic_rebound(damping, End::Overlap);
            (1.153_44 * damping - lost) / (1.153_44 * damping).powi(2)
        };
        assert_near(second(0.01), 0.6, 0.02);
        // x = 0.2098 gives 0.8170 where the first order alone would want 0.183
        assert_near(viscoelastic_rebound(0.2098 / 1.153_44, End::Overlap), 0.8155, 3e-3);
    }

    /// LIGGGHTS-PUBLIC 3.8.0 run with a PTFE sphere of 8 mm, MaximumRestitution 0.727, CriticalStokes 11.28.
    #[test]
    fn the_stokes_keywords_give_what_liggghts_gave() {
        let keywords = StokesKeywords {
            maximum_restitution: 0.727,
            critical_stokes: 11.28,
        };
        for (stokes, off, on) in [
            (15.0, 0.040, 0.285),
            (25.0, 0.438, 0.477),
            (40.0, 0.658, 0.659),
            (200.0, 0.739, 0.748),
        ] {
            assert_near(keywords.rebound(stokes, End::Overlap), off, 1.5e-3);
            assert_near(keywords.rebound(stokes, End::Force), on, 1.5e-3);
        }
        // without liquid they are a constant
        let dry = StokesKeywords {
            critical_stokes: 0.0,
            ..keywords
        };
        assert_near(dry.rebound(30.0, End::Overlap), 0.727, 1e-9);
        assert_eq!(keywords.rebound(1.0, End::Overlap), 0.0);
    }

    /// The paper's square-root law for e_inf 0.727 and St_c 11.28, by least squares and by looking everywhere nearby.
    #[test]
    fn no_keywords_nearby_are_nearer() {
        let law = [
            [12.0, 0.044],
            [15.0, 0.180],
            [20.0, 0.317],
            [25.0, 0.399],
            [30.0, 0.454],
            [40.0, 0.522],
            [60.0, 0.590],
            [100.0, 0.645],
            [200.0, 0.686],
        ];
        let off = |keywords: StokesKeywords| -> f64 {
            let of = |[stokes, e]: [f64; 2]| (keywords.rebound(stokes, End::Overlap) - e).powi(2);
            (law.map(of).iter().sum::<f64>() / law.len() as f64).sqrt()
        };
        let nearest = StokesKeywords::nearest(&law, End::Overlap);
        for i in -6..=6 {
            for j in -6..=6 {
                let other = StokesKeywords {
                    maximum_restitution: nearest.maximum_restitution * (f64::from(i) / 100.0).exp(),
                    critical_stokes: nearest.critical_stokes * (f64::from(j) / 50.0).exp(),
                };
                assert!(off(nearest) < off(other) + 1e-6, "{nearest:?} {other:?}");
            }
        }
        // keywords found by another program, which looked at other Stokes numbers too, are 0.082 off
        assert!(off(nearest) < 0.082, "{nearest:?}");
    }

    /// Begun elsewhere the search ended at keywords without St, and a distance of 0.34.
    #[test]
    fn a_law_across_its_threshold_keeps_its_stokes_numbers() {
        let law: Vec<[f64; 2]> = (0..17)
            .map(|i| 0.056 * 4f64.powf(f64::from(i) / 16.0))
            .map(|stokes| [stokes, (0.6 - 0.061 / stokes).max(0.0).sqrt()])
            .collect();
        let found = StokesKeywords::nearest(&law, End::Overlap);
        for [stokes, e] in law {
            assert_near(found.rebound(stokes, End::Overlap), e, 0.1);
        }
    }
}
