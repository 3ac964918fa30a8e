//! Holds the measurement errors of runs: of the impact speed, and of the restitution beyond what it shares with that.

/// Standard deviations of what was measured, as columns in the order of the runs; 0 where a run gives none.
///
/// A restitution e = v_r/v shares the error of v: it errs by u and by −e s_v/v, so that its variance is
/// u² + (e s_v/v)² and its covariance with v is −e s_v²/v. About a law m(v) it then scatters by
/// τ² = u² + s_v² (m/v + ∂m/∂v)².
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeasurementErrors {
    /// s_v, m/s
    pub impact_speed_sd: Vec<f64>,
    /// u, what the restitution errs by beyond its share of v
    pub restitution_sd: Vec<f64>,
}

impl MeasurementErrors {
    /// The errors of as many runs, none of them with any.
    pub(super) fn none(runs: usize) -> MeasurementErrors {
        MeasurementErrors {
            impact_speed_sd: vec![0.0; runs],
            restitution_sd: vec![0.0; runs],
        }
    }

    /// Adds a run.
    pub(crate) fn push(&mut self, [impact_speed_sd, restitution_sd]: [f64; 2]) {
        self.impact_speed_sd.push(impact_speed_sd);
        self.restitution_sd.push(restitution_sd);
    }

    /// s_v and u of a run.
    pub fn of(&self, run: usize) -> [f64; 2] {
        [self.impact_speed_sd[run], self.restitution_sd[run]]
    }

    /// Runs that carry an error above 0: any at all, of the impact speed, of the restitution beyond its share of that.
    pub fn counts(&self) -> [usize; 3] {
        let both = || self.impact_speed_sd.iter().zip(&self.restitution_sd);
        let any = both().filter(|(s_v, u)| **s_v > 0.0 || **u > 0.0).count();
        let of = |column: &[f64]| column.iter().filter(|sd| **sd > 0.0).count();
        [any, of(&self.impact_speed_sd), of(&self.restitution_sd)]
    }
}

/// s_v and u of a run from what a table gives of its impact speed, rebound speed and restitution as a whole. An error of
/// 0 says as little as a missing one; that of the restitution wins over that of the rebound speed, which it contains.
pub(super) fn of_run(sds: [Option<f64>; 3], impact_speed: f64, restitution: f64) -> [f64; 2] {
    let [s_v, s_r, s_e] = sds.map(|sd| sd.filter(|sd| *sd > 0.0));
    let s_v = s_v.unwrap_or(0.0);
    let shared = restitution * s_v / impact_speed;
    let own = match (s_e, s_r) {
        (Some(s_e), _) if shared == 0.0 => s_e,
        // as two roots, so that the square of a tiny error does not vanish
        (Some(s_e), _) if s_e > shared => (s_e - shared).sqrt() * (s_e + shared).sqrt(),
        (Some(_), _) => 0.0,
        (None, Some(s_r)) => s_r / impact_speed,
        (None, None) => 0.0,
    };
    [s_v, own]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_restitution_shares_with_its_speed_is_taken_out() {
        // s_v/v = 0.05 and e = 0.6 share 0.03; 0.05² = 0.03² + 0.04²
        let [s_v, own] = of_run([Some(0.1), None, Some(0.05)], 2.0, 0.6);
        assert_eq!(s_v, 0.1);
        assert!((own - 0.04).abs() < 1e-15, "{own}");
        // the restitution's own wins over the rebound speed's
        assert_eq!(of_run([Some(0.1), Some(9.0), Some(0.05)], 2.0, 0.6)[1], own);
        assert_eq!(of_run([None, Some(0.1), None], 2.0, 0.6), [0.0, 0.05]);
        // less than its share leaves nothing
        assert_eq!(of_run([Some(0.1), None, Some(0.01)], 2.0, 0.6), [0.1, 0.0]);
        // a run that stuck shares nothing
        assert_eq!(of_run([Some(0.1), None, Some(0.05)], 2.0, 0.0), [0.1, 0.05]);
        // zero is no error, and a tiny one stays what it is
        assert_eq!(of_run([Some(0.0), Some(0.2), Some(0.0)], 2.0, 0.6), [0.0, 0.1]);
        assert_eq!(of_run([None; 3], 2.0, 0.6), [0.0, 0.0]);
        let [_, tiny] = of_run([None, None, Some(1e-300)], 2.0, 0.6);
        assert!((tiny / 1e-300 - 1.0).abs() < 1e-15, "{tiny:e}");
    }
}
