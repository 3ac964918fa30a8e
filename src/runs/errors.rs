//! Holds the measurement errors of runs: of the impact speed, and of the restitution beyond what it shares with that.

/// Standard deviations of what was measured of one run; 0 where it gives none.
///
/// A restitution e = v_r/v shares the error of v: it errs by u and by −e s_v/v, so that its variance is
/// u² + (e s_v/v)² and its covariance with v is −e s_v²/v. About a law m(v) it then scatters by
/// τ² = u² + s_v² (m/v + ∂m/∂v)²; where the errors of v and v_r are correlated, by −2 ρ u s_v (m/v + ∂m/∂v) more, with
/// u = s_r/v.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RunError {
    /// s_v, m/s
    pub impact_speed_sd: f64,
    /// u, what the restitution errs by beyond its share of v
    pub restitution_sd: f64,
    /// ρ, the correlation of the errors of v and v_r
    pub speed_correlation: f64,
}

/// How many runs carry measurement errors above 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct RunsWithErrors {
    /// with any
    pub runs: usize,
    /// with one of the impact speed
    pub of_impact_speed: usize,
    /// with one of the restitution beyond what it shares with the impact speed
    pub of_restitution: usize,
}

impl RunsWithErrors {
    /// Of runs that err so; `None` where no errors are given.
    pub fn of(errors: &[RunError]) -> Option<RunsWithErrors> {
        let count = |errs: fn(&RunError) -> bool| errors.iter().filter(|error| errs(error)).count();
        (!errors.is_empty()).then(|| RunsWithErrors {
            runs: count(|error| error.impact_speed_sd > 0.0 || error.restitution_sd > 0.0),
            of_impact_speed: count(|error| error.impact_speed_sd > 0.0),
            of_restitution: count(|error| error.restitution_sd > 0.0),
        })
    }
}

/// What a run errs by, from what a table gives of its impact speed, rebound speed and restitution as a whole, and from the
/// correlation of both speeds' errors. An error of 0 says as little as a missing one; that of the restitution wins over that
/// of the rebound speed, which it contains.
pub(super) fn of_run(sds: [Option<f64>; 3], correlation: f64, impact_speed: f64, restitution: f64) -> RunError {
    let [s_v, s_r, s_e] = sds.map(|sd| sd.filter(|sd| *sd > 0.0));
    let s_v = s_v.unwrap_or(0.0);
    let shared = restitution * s_v / impact_speed;
    // s_e² = u² − 2 ρ u shared + shared²: the part of the shared error that no u takes off
    let left = shared * ((1.0 - correlation) * (1.0 + correlation)).sqrt();
    let own = match (s_e, s_r) {
        (Some(s_e), _) if shared == 0.0 => s_e,
        // as two roots, so that the square of a tiny error does not vanish
        (Some(s_e), _) if s_e > left => (correlation * shared + (s_e - left).sqrt() * (s_e + left).sqrt()).max(0.0),
        (Some(_), _) => (correlation * shared).max(0.0),
        (None, Some(s_r)) => s_r / impact_speed,
        (None, None) => 0.0,
    };
    RunError {
        impact_speed_sd: s_v,
        restitution_sd: own,
        speed_correlation: correlation,
    }
}

#[cfg(test)]
mod tests {
    /// s_v and u without a correlation.
    fn of_run(sds: [Option<f64>; 3], impact_speed: f64, restitution: f64) -> [f64; 2] {
        let found = super::of_run(sds, 0.0, impact_speed, restitution);
        [found.impact_speed_sd, found.restitution_sd]
    }

    #[test]
    fn a_correlation_is_taken_out_of_the_restitution_as_a_whole() {
        // s_e² = u² − 2 ρ u shared + shared² with u = 0.02 and shared = 0.03
        let s_e = (0.02f64.powi(2) - 2.0 * 0.5 * 0.02 * 0.03 + 0.03f64.powi(2)).sqrt();
        let found = super::of_run([Some(0.1), None, Some(s_e)], 0.5, 2.0, 0.6);
        // of the two u that give this s_e the larger where both are above 0
        assert!((found.restitution_sd - 0.02).abs() < 1e-12 || (found.restitution_sd - 0.01).abs() < 1e-12);
        assert_eq!(found.speed_correlation, 0.5);
        assert_eq!(
            super::of_run([Some(0.1), Some(0.04), None], 0.5, 2.0, 0.6).restitution_sd,
            0.02
        );
    }

    #[test]
    fn an_error_of_the_restitution_wins_and_a_tiny_one_stays_what_it_is() {
        // the restitution's own wins over the rebound speed's
        let [alone, beside] = [None, Some(9.0)].map(|rebound| of_run([Some(0.1), rebound, Some(0.05)], 2.0, 0.6));
        assert_eq!(alone, beside);
        // zero is no error
        assert_eq!(of_run([Some(0.0), Some(0.2), Some(0.0)], 2.0, 0.6), [0.0, 0.1]);
        assert_eq!(of_run([None; 3], 2.0, 0.6), [0.0, 0.0]);
        let [_, tiny] = of_run([None, None, Some(1e-300)], 2.0, 0.6);
        assert!((tiny / 1e-300 - 1.0).abs() < 1e-15, "{tiny:e}");
    }
}
