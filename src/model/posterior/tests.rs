//! Tests of the posterior's slopes on the whole line, and of its bounds.

use std::path::Path;

use super::*;
use crate::model::parameters::ParameterKind;
use crate::physics::inertia::Inertia;
use crate::physics::{Coefficient, DrySpeed, Form};
use crate::runs::{self, NewRun};
use crate::scene::{self, LikelihoodFamily, Scene};

fn scene(extra: &str) -> Scene {
    let text = format!(
        r#"
title = "one particle"
[data]
runs = "runs.csv"
[particles.PE]
density_kg_m3 = 940
roughness_um = 5
[liquids.M50]
density_kg_m3 = 965
viscosity_mPa_s = 20
{extra}
"#
    );
    scene::parse(&text, Path::new("a/scene.toml"), String::new()).expect("a valid scene")
}

fn rows() -> Vec<NewRun<'static>> {
    (0..24)
        .map(|i| {
            let wet = i % 3 > 0;
            let film = 0.04 + 0.04 * f64::from(i % 2);
            NewRun {
                particle: "PE",
                liquid: wet.then_some("M50"),
                diameter: 6e-3,
                film: wet.then_some((film * 6e-3, film)),
                impact_speed: 0.5 + 0.06 * f64::from(i),
                restitution: if wet { 0.5 + 0.01 * f64::from(i) } else { 0.87 },
            }
        })
        .collect()
}

fn posterior(scene: &Scene, rows: &[NewRun], inertia: Inertia, dry_speed: DrySpeed) -> PosteriorDensity {
    let form = Form {
        viscous: scene.model.viscous,
        ..Form::new(inertia, dry_speed)
    };
    let runs = runs::arrange(scene, rows);
    let parameters = ModelParameters::of(scene, &runs, form).expect("priors with room");
    PosteriorDensity::new(parameters, Likelihood::new(scene, &runs, form))
}

#[test]
fn slopes_agree_with_differences_under_every_prior() {
    let priors = [
        "",
        "[priors]\nlubrication_log = { gamma = [3.0, 1.0] }\nsigma_wet = { uniform = [0.01, 0.5] }\ninertial_prefactor = { student_t = [4, 0.5, 0.3] }",
        "[model]\nlikelihood = \"student\"\nnoise = \"both\"",
        "[model]\nviscous = \"film\"\nlikelihood = \"student\"",
        "[model]\nlikelihood = \"asymmetric_laplace\"",
        "[model]\nlikelihood = \"asymmetric_laplace\"\nseries_offsets = true\nsticking = \"truncated\"",
        "[model]\nviscous = \"film\"\n[priors]\nrupture_scale = { uniform = [0.01, 5] }",
        "[priors]\ndry_k = { normal = [0.15, 0.05] }\nsigma_dry = { lognormal = [0.02, 0.5] }",
        "[model]\nseries_offsets = true",
        "[model]\nseries_offsets = true\nsticking = \"truncated\"\n[priors]\nsigma_series = { fixed = 0.02 }",
        "[model]\nseries_offsets = true\nlikelihood = \"student\"",
        "[model]\nseries_offsets = true\nlikelihood = \"student\"\nnoise = \"both\"",
        "[model]\nseries_offsets = true\nviscous = \"film\"\nnoise = \"both\"\n[priors]\nsigma_series = { lognormal = [0.01, 1] }",
    ];
    for extra in priors {
        let scene = scene(extra);
        for (inertia, dry_speed) in [
            (Inertia::Saturating, DrySpeed::Reference(2.0)),
            (Inertia::Stepwise, DrySpeed::Impact),
        ] {
            let posterior = posterior(&scene, &rows(), inertia, dry_speed);
            let parameters = posterior.parameters().clone();
            let parameters = parameters
                .with_trend(ParameterKind::LubricationTrend)
                .with_trend(ParameterKind::InertialTrend);
            let posterior = PosteriorDensity::new(parameters, posterior.likelihood.clone());
            let mut draw: Vec<f64> = posterior
                .parameters()
                .sampled
                .iter()
                .map(|p| match p.kind {
                    ParameterKind::DryK(_) => 0.13,
                    ParameterKind::LUBRICATION_LOG => 2.3,
                    ParameterKind::INERTIAL_PREFACTOR => 0.6,
                    ParameterKind::FILM_SCALE => 0.08,
                    ParameterKind::Shared(Coefficient::RuptureScale) => 0.7,
                    ParameterKind::SigmaDry => 0.03,
                    ParameterKind::SigmaWet => 0.05,
                    ParameterKind::SigmaEnergy => 0.04,
                    ParameterKind::SigmaSeries => 0.015,
                    ParameterKind::Shape(LikelihoodFamily::AsymmetricLaplace) => -0.6,
                    ParameterKind::Shape(_) => 7.0,
                    ParameterKind::LubricationTrend => 0.3,
                    ParameterKind::InertialTrend => -0.4,
                })
                .collect();
            let offsets = posterior.parameters().series_offsets.len();
            assert_eq!(offsets > 0, extra.contains("series_offsets"));
            draw.extend([0.012, -0.03].into_iter().take(offsets));
            let about = posterior.parameters().full(&draw);
            let posterior = posterior.with_offsets_about(&about);
            let point = posterior.point_at(&draw);
            let back = posterior.draw_at(&point);
            assert!(draw.iter().zip(&back).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
            let mut slopes = vec![0.0; point.len()];
            let mut unused = slopes.clone();
            posterior.ln_density(&point, &mut slopes).expect("inside");
            for place in 0..point.len() {
                let mut at = |step: f64| {
                    let mut shifted = point.clone();
                    shifted[place] += step;
                    posterior.ln_density(&shifted, &mut unused).expect("inside")
                };
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                let gap = (difference - slopes[place]).abs() / (1.0 + difference.abs());
                assert!(gap < 1e-6, "{extra} {place} {difference} {}", slopes[place]);
            }
        }
    }
}

#[test]
fn k_is_bounded_where_the_dry_law_turns_negative() {
    let scene = scene("");
    for (dry_speed, fastest) in [
        (DrySpeed::Reference(2.0), 2.0f64),
        (DrySpeed::Reference(0.3), 1.76),
        (DrySpeed::Impact, 1.88),
    ] {
        let posterior = posterior(&scene, &rows(), Inertia::Cap, dry_speed);
        let place = posterior.parameters().place(ParameterKind::DryK(0)).expect("sampled");
        let (_, most) = posterior.parameters().sampled[place].bounds;
        assert!((most - fastest.powf(-0.2)).abs() < 1e-12, "{dry_speed:?} {most}");
        for far in [-50.0, 50.0] {
            let k = posterior.draw_at(&vec![far; posterior.dimension()])[place];
            assert!(k >= 0.0 && k <= most, "{k}");
        }
    }
}
