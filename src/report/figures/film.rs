//! Says what the figures against the film ratio show, as the paper's figs. 4 and 5 have them.

use super::super::chart::{Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::super::Told;
use super::points::{chart, curve, points, steps};
use crate::findings::estimate::Estimate;
use crate::findings::scaling::Scaling;
use crate::physics::inertia::Inertia;
use crate::scene::WetLaw;

fn estimate_point(film_ratio: f64, estimate: &Estimate) -> Option<ChartPoint> {
    Some(ChartPoint {
        x: film_ratio,
        y: estimate.value?,
        y_se: estimate.se,
    })
}

/// e_inf and St_c against the film ratio: a colour a particle, hollow for the linear law.
pub(super) fn film(told: Told) -> Vec<Chart> {
    let panel = |label: &str, of: fn(&Scaling) -> &Estimate| {
        let mut layers = vec![];
        for (index, particle) in told.scene.particles.iter().enumerate() {
            for (law, words) in [(WetLaw::Sqrt, "square root"), (WetLaw::Linear, "linear")] {
                let rows = told.findings.scaling.iter();
                let mine = rows.filter(|r| r.particle == particle.name && r.law == law.name() && r.verdict.passed);
                let points_of: Vec<ChartPoint> = mine.filter_map(|r| estimate_point(r.film_ratio?, of(r))).collect();
                let style = Style {
                    group: index + 1,
                    open: law == WetLaw::Linear,
                };
                if !points_of.is_empty() {
                    layers.push(points(format!("{}, {words}", particle.name), points_of, style));
                }
            }
        }
        chart(Axis::new("film ratio δ/D"), Axis::new(label), layers)
    };
    vec![panel("e_{inf}", |row| &row.e_inf), panel("St_{c}", |row| &row.st_c)]
}

/// The inertial loss with both predictions, and St_c e_inf², against the film ratio, by the square-root law.
pub(super) fn energy(told: Told) -> Vec<Chart> {
    let rows = || told.findings.energy.iter().filter(|row| row.law == WetLaw::Sqrt.name());
    let end = rows().map(|row| row.film_ratio).reduce(f64::max).unwrap_or(0.1) * 1.08;
    let of_particles = |of: fn(&crate::findings::energy::Energy) -> &Estimate| -> Vec<Layer> {
        let names = told.scene.particles.iter().enumerate();
        names
            .filter_map(|(index, particle)| {
                let mine = rows().filter(|row| row.particle == particle.name);
                let points_of: Vec<ChartPoint> =
                    mine.filter_map(|row| estimate_point(row.film_ratio, of(row))).collect();
                let style = Style::group(index + 1);
                (!points_of.is_empty()).then(|| points(particle.name.clone(), points_of, style))
            })
            .collect()
    };
    let mut loss = of_particles(|row| &row.loss_over_density_ratio);
    if !loss.is_empty() {
        for (form, words, dash) in [
            (Inertia::Stepwise, "stepwise, eq. Eint2", Dash::Solid),
            (Inertia::Cap, "cap, eq. Eint1", Dash::Dashed),
        ] {
            let last = end.min(form.valid_to());
            let law = steps(0.0, last).map(|x| (x, form.shape(x, 1.0))).collect();
            loss.push(curve(words, law, Style::group(0), dash));
        }
    }
    if let Some((form, c, scale)) = fitted_form(told).filter(|_| !loss.is_empty()) {
        let law = steps(0.0, end.min(form.valid_to()))
            .map(|x| (x, c * form.shape(x, scale)))
            .collect();
        loss.push(curve(
            format!("fitted, {}", form.name()),
            law,
            Style::group(0),
            Dash::Dotted,
        ));
    }
    vec![
        chart(
            Axis::new("film ratio δ/D"),
            Axis::new("(e_{dry}^{2} − e_{inf}^{2})/ρ̃"),
            loss,
        ),
        chart(
            Axis::new("film ratio δ/D"),
            Axis::new("St_{c} e_{inf}^{2}"),
            of_particles(|row| &row.st_c_e_inf2),
        ),
    ]
}

/// Mean residual of each particle and film ratio under the scene's own model; nothing where the film was not asked about.
pub(super) fn residuals(told: Told) -> Vec<Chart> {
    let Some(posterior) = told.posterior.filter(|_| told.findings.questions.is_some()) else {
        return vec![];
    };
    let groups = &posterior.findings.predictive.groups;
    let wet = groups.iter().filter_map(|group| group.film_ratio);
    let end = 1.08 * wet.reduce(f64::max).unwrap_or(0.1);
    let mut layers = vec![curve(
        "the model",
        vec![(0.0, 0.0), (end, 0.0)],
        Style::group(0),
        Dash::Dashed,
    )];
    for (index, particle) in told.scene.particles.iter().enumerate() {
        let mine = groups.iter().filter(|group| group.particle == particle.name);
        let points_of = mine.filter_map(|group| {
            Some(ChartPoint {
                x: group.film_ratio?,
                y: group.mean_residual,
                y_se: group.mean_residual_se,
            })
        });
        let points_of: Vec<ChartPoint> = points_of.collect();
        if !points_of.is_empty() {
            layers.push(points(particle.name.clone(), points_of, Style::group(index + 1)));
        }
    }
    vec![chart(
        Axis::new("film ratio δ/D").between(0.0, end),
        Axis::new("mean residual in σ"),
        layers,
    )]
}

/// The inertial form of the energy balance with its fitted C and δ̃0, where it may be quoted.
fn fitted_form(told: Told) -> Option<(Inertia, f64, f64)> {
    let balance = told
        .findings
        .energy_balance
        .as_ref()
        .filter(|balance| balance.verdict.passed)?;
    let form = Inertia::ALL.into_iter().find(|form| form.name() == balance.inertia)?;
    let value = |name: &str| {
        let parameter = balance.parameters.iter().find(|parameter| parameter.name == name)?;
        parameter.estimate.value
    };
    Some((form, value("inertial_prefactor")?, value("film_scale").unwrap_or(1.0)))
}
