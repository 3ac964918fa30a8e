//! States each law of the restitution once: its parameters, value, slopes, bends, domain and derivatives in the speed.
//!
//! Every law is e = F(η) of a linear predictor η = b₀ c₀(x) + b₁ c₁(x) + o. Its abscissa x is proportional to a power of
//! the impact speed, and o is a known offset.
//!
//! | law | x | η | F(η) |
//! |---|---|---|---|
//! | dry | v^(1/5) | k x | 1 − η, to second order 1 − η + (3/5) η² |
//! | linear | 1/v or 1/St | a − b x | η |
//! | square root | 1/v or 1/St | α + β x + o | √η, defined for η > 0 |
//!
//! Slopes and bends in the parameters follow by the chain rule: ∂e/∂b_j = F′ c_j and ∂²e/∂b_i∂b_j = F″ c_i c_j.

use crate::physics::dry::Order;
use crate::physics::rebound::{bend_mean_restitution, mean_restitution, slope_mean_restitution};
use crate::scene::WetLaw;

/// A law of the restitution of single impacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// of dry impacts, over v^(1/5)
    Dry(Order),
    /// of wet impacts, over 1/v or 1/St
    Wet(WetLaw),
}

/// F(η) with its derivatives in η.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// F, the restitution
    pub value: f64,
    /// F′
    pub slope: f64,
    /// F″
    pub bend: f64,
}

/// A restitution m at one run with its derivatives in the speed v, primes, made dimensionless by powers of v.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpeedResponse {
    /// m
    pub value: f64,
    /// v m′
    pub slope: f64,
    /// v² m″
    pub bend: f64,
}

impl SpeedResponse {
    /// Error of the residual e − m for a unit relative error of v, which e = v_r/v shares: m + v m′.
    pub fn error_slope(&self) -> f64 {
        self.value + self.slope
    }

    /// E[r J] for a unit variance of the relative error of v, from a slope J of m in a parameter, and v J′:
    /// J (m − v² m″/2) − v J′ (m + v m′).
    pub fn second_order_bias(&self, jacobian: f64, jacobian_slope: f64) -> f64 {
        jacobian * (self.value - 0.5 * self.bend) - jacobian_slope * self.error_slope()
    }
}

/// A law at one run with its derivatives in the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawInSpeed {
    /// the restitution
    pub response: SpeedResponse,
    /// its slopes J_j in the parameters
    pub jacobian: [f64; 2],
    /// v J_j′
    pub jacobian_slope: [f64; 2],
}

impl Law {
    /// e = a − b x.
    pub const LINEAR: Law = Law::Wet(WetLaw::Linear);
    /// e = √(α + β x + o).
    pub const SQUARE_ROOT: Law = Law::Wet(WetLaw::Sqrt);

    /// Number of parameters, 1 or 2. Where two numbers are passed for one parameter, the second is 0.
    pub fn parameters(self) -> usize {
        match self {
            Law::Dry(_) => 1,
            Law::Wet(_) => 2,
        }
    }

    /// The power of the speed that the abscissa is proportional to.
    pub fn speed_power(self) -> f64 {
        match self {
            Law::Dry(_) => 0.2,
            Law::Wet(_) => -1.0,
        }
    }

    /// Abscissa at a speed in m/s, as (m/s)^(1/5) or s/m.
    pub fn abscissa(self, speed: f64) -> f64 {
        match self {
            Law::Dry(_) => speed.powf(self.speed_power()),
            Law::Wet(_) => 1.0 / speed,
        }
    }

    /// Abscissae at these speeds.
    pub fn abscissae(self, speeds: &[f64]) -> Vec<f64> {
        speeds.iter().map(|v| self.abscissa(*v)).collect()
    }

    /// c₀ and c₁ at an abscissa: the slopes of the linear predictor in the parameters.
    pub fn design(self, x: f64) -> [f64; 2] {
        match self {
            Law::Dry(_) => [x, 0.0],
            Law::Wet(WetLaw::Linear) => [1.0, -x],
            Law::Wet(WetLaw::Sqrt) => [1.0, x],
        }
    }

    /// The u with H u = g for a symmetric H of entries 00, 01, 11; of one parameter the first entry alone.
    pub fn solve(self, [h0, h1, h2]: [f64; 3], [g0, g1]: [f64; 2]) -> [f64; 2] {
        if self.parameters() == 1 {
            return [g0 / h0, 0.0];
        }
        let determinant = h0 * h2 - h1 * h1;
        [(h2 * g0 - h1 * g1) / determinant, (h0 * g1 - h1 * g0) / determinant]
    }

    /// The linear predictor η.
    pub fn predictor(self, parameters: [f64; 2], x: f64, offset: f64) -> f64 {
        let design = self.design(x);
        parameters[0] * design[0] + parameters[1] * design[1] + offset
    }

    /// Whether the law is defined at a linear predictor; the square root is not at a NaN.
    pub fn is_defined(self, predictor: f64) -> bool {
        match self {
            Law::Wet(WetLaw::Sqrt) => predictor > 0.0,
            Law::Dry(_) | Law::Wet(WetLaw::Linear) => true,
        }
    }

    /// The law and its derivatives at a linear predictor inside its domain.
    #[inline(always)] // loops over runs need only one of the three
    pub fn response(self, predictor: f64) -> Response {
        match self {
            Law::Dry(order) => {
                let [value, slope, bend] = order.of_loss(predictor);
                Response { value, slope, bend }
            }
            Law::Wet(WetLaw::Linear) => Response {
                value: predictor,
                slope: 1.0,
                bend: 0.0,
            },
            Law::Wet(WetLaw::Sqrt) => {
                let value = predictor.sqrt();
                let slope = 0.5 / value;
                Response {
                    value,
                    slope,
                    // a product: dividing takes several times as long
                    bend: -2.0 * slope * slope * slope,
                }
            }
        }
    }

    /// The law and its derivatives at any linear predictor: the square root's are those of m(r), which goes on below zero.
    #[inline(always)] // as of `response`
    pub fn continued(self, predictor: f64) -> Response {
        match self {
            Law::Wet(WetLaw::Sqrt) => Response {
                value: mean_restitution(predictor),
                slope: slope_mean_restitution(predictor),
                bend: bend_mean_restitution(predictor),
            },
            Law::Dry(_) | Law::Wet(WetLaw::Linear) => self.response(predictor),
        }
    }

    /// The restitution at an abscissa; 0 where the law is undefined, as nothing rebounds there.
    pub fn restitution(self, parameters: [f64; 2], x: f64, offset: f64) -> f64 {
        let predictor = self.predictor(parameters, x, offset);
        if self.is_defined(predictor) {
            self.response(predictor).value
        } else {
            0.0
        }
    }

    /// The law with its derivatives in the speed at an abscissa and at a linear predictor inside the domain.
    ///
    /// `offset_slopes` are v o′ and v² o″ of the known offset.
    pub fn in_speed(self, parameters: [f64; 2], x: f64, predictor: f64, offset_slopes: [f64; 2]) -> LawInSpeed {
        let Response { value, slope, bend } = self.response(predictor);
        let power = self.speed_power();
        let (design, constant) = (self.design(x), self.design(0.0));
        // what of the design is proportional to x
        let moving = [design[0] - constant[0], design[1] - constant[1]];
        let along = parameters[0] * moving[0] + parameters[1] * moving[1];
        let predictor_slope = power * along + offset_slopes[0];
        let predictor_bend = power * (power - 1.0) * along + offset_slopes[1];
        LawInSpeed {
            response: SpeedResponse {
                value,
                slope: slope * predictor_slope,
                bend: bend * predictor_slope * predictor_slope + slope * predictor_bend,
            },
            jacobian: design.map(|c| slope * c),
            jacobian_slope: [0, 1].map(|j| bend * predictor_slope * design[j] + slope * power * moving[j]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;
    use rand::RngExt;

    const LAWS: [Law; 4] = [
        Law::Dry(Order::First),
        Law::Dry(Order::Second),
        Law::LINEAR,
        Law::SQUARE_ROOT,
    ];

    /// Parameters with which a law gives restitutions between 0.3 and 0.9 at 1/v, v between 0.4 and 4 m/s.
    fn parameters(law: Law, uniform: &mut impl FnMut() -> f64) -> [f64; 2] {
        match law {
            Law::Dry(_) => [0.1 + 0.2 * uniform(), 0.0],
            Law::Wet(WetLaw::Linear) => [0.7 + 0.2 * uniform(), 0.05 + 0.1 * uniform()],
            Law::Wet(WetLaw::Sqrt) => [0.5 + 0.3 * uniform(), -0.05 - 0.1 * uniform()],
        }
    }

    /// Compares a slope that is stated with a central difference; both of order one.
    fn near(stated: f64, more: f64, less: f64, apart: f64) {
        let found = (more - less) / apart;
        assert!(
            (stated - found).abs() < 1e-6 * (1.0 + found.abs()),
            "{stated} and {found}"
        );
    }

    #[test]
    fn slopes_and_bends_agree_with_differences() {
        const STEP: f64 = 1e-5;
        let mut rng = stream(1, "slopes_and_bends_agree_with_differences", 0);
        let mut uniform = || rng.random::<f64>();
        for law in LAWS {
            for _ in 0..100 {
                let b = parameters(law, &mut uniform);
                let v = 0.4 * 10f64.powf(uniform());
                let at = |b: [f64; 2], factor: f64| {
                    let v = v * factor;
                    // an offset o = 0.05 v^1.5
                    let offset = 0.05 * v.powf(1.5);
                    let x = law.abscissa(v);
                    let predictor = law.predictor(b, x, offset);
                    assert!(law.is_defined(predictor));
                    (predictor, law.in_speed(b, x, predictor, [1.5 * offset, 0.75 * offset]))
                };
                let (predictor, here) = at(b, 1.0);
                let [less, more] = [predictor - STEP, predictor + STEP].map(|predictor| law.response(predictor));
                let response = law.response(predictor);
                near(response.slope, more.value, less.value, 2.0 * STEP);
                near(response.bend, more.slope, less.slope, 2.0 * STEP);
                for j in 0..law.parameters() {
                    let moved = |step: f64| {
                        let mut b = b;
                        b[j] += step;
                        at(b, 1.0).1.response.value
                    };
                    near(here.jacobian[j], moved(STEP), moved(-STEP), 2.0 * STEP);
                }
                let (less, more) = (at(b, 1.0 - STEP).1, at(b, 1.0 + STEP).1);
                let [of_less, of_here, of_more] = [less, here, more].map(|at| at.response);
                near(of_here.slope, of_more.value, of_less.value, 2.0 * STEP);
                // v (v e′)′ = v e′ + v² e″
                near(of_here.slope + of_here.bend, of_more.slope, of_less.slope, 2.0 * STEP);
                for j in 0..2 {
                    near(here.jacobian_slope[j], more.jacobian[j], less.jacobian[j], 2.0 * STEP);
                }
            }
        }
    }

    #[test]
    fn a_law_outside_its_domain_gives_no_rebound() {
        assert!(!Law::SQUARE_ROOT.is_defined(0.0) && !Law::SQUARE_ROOT.is_defined(f64::NAN));
        assert_eq!(Law::SQUARE_ROOT.restitution([0.5, -1.0], 0.6, 0.0), 0.0);
        assert_eq!(Law::SQUARE_ROOT.restitution([0.5, -1.0], 0.6, 0.35), 0.5);
        assert_eq!(Law::LINEAR.restitution([0.75, 0.5], 0.5, 0.0), 0.5);
    }
}
