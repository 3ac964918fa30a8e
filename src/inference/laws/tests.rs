use super::*;

/// Slopes in the speed against differences, at speeds that are not round.
fn assert_slopes<P: OfSpeed>(law_at: impl Fn(&[f64]) -> (P, Vec<[f64; 2]>), b: &[f64]) {
    const STEP: f64 = 1e-5;
    let speed = [0.37, 0.81, 1.13, 2.71];
    let at = |factor: f64| {
        let moved = speed.map(|v| v * factor);
        let (law, offset_slopes) = law_at(&moved);
        let none = [0.0; 4];
        let erring = Erring {
            speed: &moved,
            impact_speed_sd: &none,
            restitution_sd: &none,
            offset_slopes: &offset_slopes,
        };
        let all = law.in_speed(b, &erring).expect("inside the domain");
        let (mut residuals, mut jacobian) = (vec![0.0; 4], DMatrix::zeros(4, b.len()));
        law.residuals(b, &mut residuals).expect("inside the domain");
        law.jacobian(b, &mut jacobian).expect("inside the domain");
        // restitutions are 0
        assert_eq!(all.value, residuals);
        assert!((&all.jacobian - &jacobian).abs().max() < 1e-15);
        all
    };
    let (less, here, more) = (at(1.0 - STEP), at(1.0), at(1.0 + STEP));
    for (run, v) in speed.iter().enumerate() {
        let apart = 2.0 * STEP * v;
        let near = |told: f64, more: f64, less: f64| {
            let found = (more - less) / apart;
            assert!(
                (told - found).abs() < 1e-7 * (1.0 + found.abs()),
                "{run}: {told} and {found}"
            );
        };
        near(here.slope[run], more.value[run], less.value[run]);
        near(here.bend[run], more.slope[run], less.slope[run]);
        for j in 0..b.len() {
            near(
                here.jacobian_slope[(run, j)],
                more.jacobian[(run, j)],
                less.jacobian[(run, j)],
            );
        }
    }
}

const NONE: [f64; 4] = [0.0; 4];

#[test]
fn slopes_in_the_speed_are_those_of_differences() {
    for order in [Order::First, Order::Second] {
        assert_slopes(
            |speed| {
                let speed_root: Vec<f64> = speed.iter().map(|v| v.powf(0.2)).collect();
                let law = DryLaw {
                    order,
                    speed_root: speed_root.leak(),
                    restitution: &NONE,
                };
                (law, vec![])
            },
            &[0.23],
        );
    }
    let inverse = |speed: &[f64]| -> &'static [f64] { speed.iter().map(|v| 1.7 / v).collect::<Vec<_>>().leak() };
    assert_slopes(
        |speed| {
            let law = LinearLaw {
                x: inverse(speed),
                restitution: &NONE,
            };
            (law, vec![])
        },
        &[0.71, 0.043],
    );
    // an offset o = 0.05 v^1.5
    assert_slopes(
        |speed| {
            let law = SquareRootLaw {
                x: inverse(speed),
                offset: speed.iter().map(|v| 0.05 * v.powf(1.5)).collect::<Vec<_>>().leak(),
                restitution: &NONE,
                without: vec![],
            };
            let slopes = speed.iter().map(|v| [0.075 * v.sqrt(), 0.0375 / v.sqrt()]);
            (law, slopes.collect())
        },
        &[0.52, -0.061],
    );
}
