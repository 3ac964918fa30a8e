//! Checks the fit where the model is undefined nearby, and from starts far away.

use super::*;

#[test]
fn starts_outside_the_domain_say_so() {
    let law = SqrtLaw::about(0.8, -0.3, 0.012, &speeds(20));
    for start in [[-1.0, 0.0], [0.1, -0.3], [f64::NAN, 0.0], [0.5, f64::NEG_INFINITY]] {
        let fit = fit(&law, &start);
        assert_no_bars(&fit, Stop::OutOfDomain, "undefined at the starting values");
        assert_eq!(fit.residual_sum_of_squares, f64::INFINITY);
    }
}

#[test]
fn a_start_anywhere_ends_at_the_minimum_or_says_that_it_did_not() {
    let law = SqrtLaw::about(0.8, -0.3, 0.012, &speeds(20));
    let good = fit(&law, &[0.8, -0.3]);
    let mut converged = 0;
    for exponent in -9..10 {
        // From far above the edge (β = 10 α) to 1 % inside it (β = −0.6 α at 0.6 m/s).
        for part in [10.0, 1.0, 0.1, 0.0, -0.3, -0.5, -0.59, -0.594] {
            let alpha = 10.0_f64.powi(exponent);
            law.evaluations.set(0);
            let fit = fit(&law, &[alpha, part * alpha]);
            assert!(law.evaluations.get() < 30_000, "{fit:?}");
            if fit.converged() {
                converged += 1;
                assert!(close(fit.parameters[0], good.parameters[0], 1e-9), "{fit:?}");
                assert!(close(fit.se(1).unwrap(), good.se(1).unwrap(), 1e-7));
            } else {
                assert_no_bars(&fit, fit.stop, "");
            }
        }
    }

    assert!(converged == 152, "{converged} of 152");
}

#[test]
fn a_minimum_close_to_the_edge_is_met_to_rounding() {
    // One run rebounds from below the others' threshold of 0.375 m/s. It holds the law's edge
    // against their pull, and undamped steps overshoot for ever.
    for slowest in [0.36, 0.33] {
        let mut v: Vec<f64> = (0..1000).map(|i| 0.5 + 0.001 * i as f64).collect();
        v.push(0.5);
        let mut law = SqrtLaw::about(0.8, -0.3, 0.02, &v);
        law.u[1000] = 1.0 / slowest;
        law.e[1000] = 0.3;
        let end = fit(&law, &[0.8, -0.2]);
        assert_eq!(end.stop, Stop::Converged, "{end:?}");
        let again = fit(&law, &end.parameters);
        for j in 0..2 {
            let moved = (again.parameters[j] - end.parameters[j]).abs();
            assert!(moved <= 1e-8 * end.se(j).unwrap(), "{slowest}: {moved:e} {end:?}");
        }
        let mut lean = [0.0, 0.0];
        let mut length = [0.0, 0.0];
        for (u, e) in law.u.iter().zip(&law.e) {
            let root = (end.parameters[0] + end.parameters[1] * u).sqrt();
            for (j, slope) in [0.5 / root, 0.5 * u / root].into_iter().enumerate() {
                lean[j] += (root - e) * slope;
                length[j] += slope * slope;
            }
        }
        for j in 0..2 {
            assert!(
                lean[j].abs() < 1e-8 * length[j].sqrt() * end.residual_sd.unwrap(),
                "{lean:?}"
            );
        }
    }
}

#[test]
fn an_optimum_on_the_edge_of_the_domain_has_no_error_bars() {
    // The slowest run stuck (e = 0) and the others ask for a threshold above its speed.
    let law = SqrtLaw::new(&[0.5, 0.8, 1.0, 1.4, 2.0], &[0.0, 0.05, 0.4, 0.6, 0.7]);
    let fit = fit(&law, &[0.8, -0.2]);
    assert_no_bars(&fit, Stop::OutOfDomain, "edge");
    assert!(fit.residual_sum_of_squares < 0.1474);
    // It moved towards the edge, and stayed inside.
    let at_slowest = fit.parameters[0] + fit.parameters[1] / 0.5;
    assert!(at_slowest > 0.0 && at_slowest < 0.01, "{at_slowest}");
}

#[test]
fn residuals_that_are_no_numbers_are_outside_the_domain() {
    // ln b is a NaN below 0 and −∞ at 0, 1e200² is infinite: none may end in a result.
    let log = curve(&[-2.0, -2.1, -1.9, -2.05], 1, |b, _| b[0].ln(), |b, _, _| 1.0 / b[0]);
    // The undamped step from 5 leads to −13.
    let from_above = fit(&log, &[5.0]);
    assert_eq!(from_above.stop, Stop::Converged);
    assert!(
        close(from_above.parameters[0], (-2.0125_f64).exp(), 1e-10),
        "{from_above:?}"
    );
    for start in [0.0, -1.0] {
        assert_no_bars(&fit(&log, &[start]), Stop::OutOfDomain, "undefined");
    }
    let huge = curve(&[1e200, 2e200], 1, |b, _| b[0], |_, _, _| 1.0);
    assert_no_bars(&fit(&huge, &[0.0]), Stop::OutOfDomain, "undefined");
    let no_slope = curve(&[1.0, 2.0], 1, |b, _| b[0], |_, _, _| f64::NAN);
    assert_no_bars(&fit(&no_slope, &[0.0]), Stop::OutOfDomain, "undefined");
}
