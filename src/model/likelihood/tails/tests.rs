//! Tests densities, probabilities and draws against other arithmetic, and their slopes against differences.

use super::*;
use statrs::distribution::{Continuous, ContinuousCDF, StudentsT};

const PROBABILITIES: [(f64, f64, f64, f64); 15] = [
    (2.1, -60.0, -9.224_807_714_027_09, -3.410_009_888_563_554_4),
    (2.1, -5.0, -4.070_281_803_661_889, -0.989_671_669_100_836_1),
    (2.1, -0.3, -0.927_243_681_539_862_7, -0.014_536_757_565_189_82),
    (2.1, 0.7, -0.323_909_074_487_349_85, 0.020_052_309_788_654_864),
    (2.1, 25.0, -6.184_992_712_925_948e-4, 1.569_499_135_709_631_7e-3),
    (4.0, -60.0, -15.280_616_826_848_478, -3.011_998_099_141_487),
    (4.0, -5.0, -5.587_275_735_616_685, -0.654_017_802_993_308_4),
    (4.0, -0.3, -0.942_735_548_697_652_5, -4.556_744_051_648_185e-3),
    (4.0, 0.7, -0.302_795_822_338_620_6, 6.138_752_755_864_99e-3),
    (4.0, 25.0, -7.598_791_752_402_79e-6, 1.627_063_640_036_615e-5),
    (250.0, -60.0, -345.443_313_400_883_7, -0.901_517_425_808_856_1),
    (250.0, -5.0, -14.431_871_642_111_911, -2.379_333_697_804_367e-3),
    (250.0, -0.3, -0.961_776_646_759_325_5, -1.303_767_435_538_147_4e-6),
    (250.0, 0.7, -0.277_453_345_576_436_8, 1.716_673_198_070_885_2e-6),
    (250.0, 25.0, -2.919_964_523_511_787e-70, 7.903_270_829_565_252e-71),
];

fn of_student(nu: f64) -> Tails {
    Tails::of(LikelihoodFamily::Student, nu)
}

fn of_laplace(asymmetry: f64) -> Tails {
    Tails::of(LikelihoodFamily::AsymmetricLaplace, asymmetry)
}

/// mpmath, 50 digits: the log of betainc(ν/2, ½, 0, ν/(ν+z²), regularized)/2, one less it above 0, and diff in ν.
#[test]
fn probabilities_are_those_of_fifty_digit_arithmetic() {
    for (nu, z, value, slope) in PROBABILITIES {
        // those of t itself
        let tails = Student {
            quantile: 1.0,
            quantile_slope: 0.0,
            ..Student::new(nu)
        };
        let found = Tails::Student(tails).ln_probability(z);
        assert!(
            (found.value - value).abs() < 1e-12 * value.abs() + 1e-18,
            "{nu} {z}: {found:?} {value}"
        );
        assert!(
            (found.shape - slope).abs() < 1e-6 * slope.abs() + 1e-12,
            "{nu} {z}: {found:?} {slope}"
        );
        let oracle = StudentsT::new(0.0, 1.0, nu).expect("valid");
        let mills = oracle.pdf(z) / oracle.cdf(z);
        assert!(
            (found.z - mills).abs() < 1e-9 * mills + 1e-18,
            "{nu} {z}: {found:?} {mills}"
        );
    }
}

/// A sampler may try what is no number; it gets an error.
#[test]
fn what_is_no_number_has_no_probability() {
    for (nu, z) in [(f64::NAN, 1.0), (4.0, f64::NAN), (f64::INFINITY, 1.0), (0.0, 1.0)] {
        let found = of_student(nu).ln_probability(z);
        assert!(
            !found.value.is_finite() || !found.shape.is_finite(),
            "{nu} {z}: {found:?}"
        );
    }
    for z in [f64::INFINITY, -1e300, 1e300] {
        let found = of_student(4.0).ln_probability(z);
        assert!(!found.value.is_nan(), "{z}: {found:?}");
    }
}

#[test]
fn slopes_agree_with_differences() {
    let near = |slope: f64, [less, more]: [f64; 2], apart: f64| {
        let found = (more - less) / apart;
        assert!((slope - found).abs() < 1e-5 * (1.0 + found.abs()), "{slope} {found}");
    };
    let students = [2.5, 7.0, 60.0].map(|nu| (LikelihoodFamily::Student, nu));
    let asymmetries = [-12.0, -3.0, -0.7, 0.0, 1.5, 4.0, 9.0];
    let laplaces = asymmetries.map(|asymmetry| (LikelihoodFamily::AsymmetricLaplace, asymmetry));
    for (family, shape) in students.into_iter().chain(laplaces) {
        let tails = Tails::of(family, shape);
        let beside = [shape - 1e-3, shape + 1e-3].map(|shape| Tails::of(family, shape));
        for z in [-8.0, -1.3, -0.02, 0.0, 0.4, 5.0] {
            const STEP: f64 = 1e-5;
            let around = [z - STEP, z + STEP];
            let of = tails.ln_probability(z);
            near(of.z, around.map(|z| tails.ln_probability(z).value), 2.0 * STEP);
            near(of.shape, beside.map(|of| of.ln_probability(z).value), 2e-3);
            let of = tails.ln_density(z);
            near(of.z, around.map(|z| tails.ln_density(z).value), 2.0 * STEP);
            near(of.shape, beside.map(|of| of.ln_density(z).value), 2e-3);
        }
    }
}

#[test]
fn draws_have_the_quartiles_of_their_tails() {
    const DRAWS: usize = 40_000;
    let mut rng = crate::seed::stream(1, "draws_have_the_quartiles_of_their_tails", 0);
    for (tails, other) in [
        (of_student(3.0), Tails::Normal),
        (Tails::Normal, of_student(3.0)),
        (of_laplace(-1.0), of_laplace(1.0)),
    ] {
        let z = |below: f64, probability: f64| {
            (below - DRAWS as f64 * probability) / (DRAWS as f64 * probability * (1.0 - probability)).sqrt()
        };
        let draw = |_: &usize| tails.draw(&mut rng) < -2.0;
        let below = (0..DRAWS).filter(draw).count() as f64;
        assert!(z(below, tails.probability(-2.0)).abs() < 4.0, "{tails:?} {below}");
        assert!(z(below, other.probability(-2.0)).abs() > 20.0, "{tails:?} {below}");
    }
}

/// Of every asymmetry the density adds up to one and to F; mean 0 and variance 1.
#[test]
fn an_asymmetric_laplace_is_a_distribution() {
    const STEP: f64 = 1e-3;
    for asymmetry in [-12.0, -3.0, -0.7, 0.0, 1.5, 4.0, 9.0] {
        let tails = of_laplace(asymmetry);
        let [mut mass, mut mean, mut square] = [0.0; 3];
        for step in -40_000..40_000 {
            // the middle of a step
            let z = (f64::from(step) + 0.5) * STEP;
            let part = STEP * tails.ln_density(z).value.exp();
            mass += part;
            mean += part * z;
            square += part * z * z;
            if step % 500 == 499 && mass > 1e-12 {
                let end = z + 0.5 * STEP;
                let below = tails.probability(end);
                assert!(
                    (mass - below).abs() < 1e-8 + 1e-5 * below,
                    "{asymmetry} {end}: {mass} {below}"
                );
            }
        }
        for (found, expected) in [(mass, 1.0), (mean, 0.0), (square, 1.0)] {
            assert!((found - expected).abs() < 1e-6, "{asymmetry}: {found} {expected}");
        }
    }
}
