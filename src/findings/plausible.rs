//! Questions constants, runs and results that no such experiment has: a wrong unit shows there first.

use std::ops::Range;

use super::document::Findings;
use super::dry::fit_of_sphere;
use super::estimate::Estimate;
use super::noise::Outlier;
use super::posterior::QuantitySummary;
use super::range::range;
use super::remarks::{self, shortened, Kind};
use crate::model::parameters::ParameterKind;
use crate::physics::numbers::same_diameter;
use crate::remark::Remark;
use crate::rounding::{significant, to_digits, LARGE};
use crate::runs::{Runs, Series};
use crate::scene::{Particle, Scene, DRY};
use crate::units::{Dimension, Unit};

/// What a quantity lies between in every experiment with spheres on wetted plates, with room to spare.
struct Bounds {
    word: &'static str,
    dimension: Dimension,
    /// lowest and highest, in the usual unit of the dimension
    within: [f64; 2],
}

const fn bounds(word: &'static str, dimension: Dimension, within: [f64; 2]) -> Bounds {
    Bounds {
        word,
        dimension,
        within,
    }
}

// foams to heavy metals, liquid metals with them
const DENSITY: Bounds = bounds("density", Dimension::Density, [300.0, 25_000.0]);
// liquid gases have 0.1 mPa s, the stiffest silicone oils 10⁶
const VISCOSITY: Bounds = bounds("viscosity", Dimension::Viscosity, [0.01, 1e7]);
// thinner films are not measured as such: they are as thin as surfaces are rough
const FILM: Bounds = bounds("film", Dimension::Thickness, [2.0, 20_000.0]);
const DIAMETER: Bounds = bounds("diameter", Dimension::Length, [0.02, 500.0]);
// mica to sandpaper
const ROUGHNESS: Bounds = bounds("roughness", Dimension::Thickness, [1e-4, 200.0]);

/// k of spheres that rebound, (m/s)^(-1/5).
const DRY_K: [f64; 2] = [0.005, 0.7];

/// L below this has its film cut off at 1.35 times the roughness.
const LEAST_LUBRICATION_LOG: f64 = 0.3;

/// C is 1 as derived, and smaller as measured: no sphere sets in motion twice the liquid that it displaces.
const MOST_PREFACTOR: f64 = 2.0;

/// Where no ε is given it is taken to be no smaller than that of the smoothest bearing balls, m: a δc as thick as the film then
/// is the largest L there is.
const SMOOTHEST: f64 = 0.01e-6;

/// Stokes numbers within which a liquid takes energy and leaves some.
const STOKES: [f64; 2] = [1.0, 1e4];

/// Spread of dry and of wet restitutions about their law, and of the energy kept from series to series, beyond which the law does not
/// describe the runs: a film off by 10 % moves the energy by 0.01, and repeated runs scatter by 0.005 to 0.05 in e.
const SPREADS: [(ParameterKind, &str, f64); 3] = [
    (ParameterKind::SigmaDry, "the spread of dry runs about their law", 0.08),
    (ParameterKind::SigmaWet, "the spread of wet runs about their law", 0.08),
    (
        ParameterKind::SigmaSeries,
        "the spread of the energy kept from series to series",
        0.03,
    ),
];

/// A film so many times its neighbours', or so small a part of them, was written in another unit.
const APART: f64 = 50.0;

/// An uncertain number is questioned where it stays outside over so many of its standard errors.
const SURE: f64 = 2.0;

/// A number in few digits, a large one as a power of ten.
fn short(x: f64) -> String {
    if x.abs() >= LARGE {
        return significant(x, 3);
    }
    to_digits(x, 3).to_string()
}

fn between([from, to]: [f64; 2]) -> String {
    let (from, to) = (short(from), short(to));
    if from == to {
        from
    } else {
        format!("{from} to {to}")
    }
}

impl Bounds {
    /// The usual unit of the dimension.
    fn usual(&self) -> &'static Unit {
        &self.dimension.units()[0]
    }

    /// What to say of the values in SI that lie outside, `of` something; `None` where none does.
    fn question(&self, of: &str, values: impl Iterator<Item = f64>) -> Option<String> {
        let values = values.map(|value| self.usual().from_si(value));
        let found = range(values.filter(|value| !self.hold(*value)))?;
        let (unit, [from, to]) = (self.usual().symbol, self.within.map(short));
        Some(format!(
            "{} of {of} is {} {unit}, outside {from} to {to} {unit}{}",
            self.word,
            between(found),
            self.likely_slip(found).unwrap_or_default()
        ))
    }

    fn hold(&self, value: f64) -> bool {
        (self.within[0]..=self.within[1]).contains(&value)
    }

    /// The unit in which the same numbers would be right.
    fn likely_slip(&self, found: [f64; 2]) -> Option<String> {
        let units = self.dimension.units();
        let holds = |factor: f64| found.iter().all(|value| self.hold(factor * value));
        // one of a unit in the usual one
        let size = |unit: &Unit| self.usual().from_si(unit.to_si(1.0));
        let mut others = units.iter().skip(1);
        if let Some(meant) = others.clone().find(|unit| holds(size(unit))) {
            return Some(format!(": {} looks like {}", between(found), meant.symbol));
        }
        let shifted = others.find(|unit| holds(1.0 / size(unit)))?;
        let factor = short(1.0 / size(shifted));
        Some(format!(": {factor} times that would do, as where a unit was mistaken"))
    }
}

/// The check of what went in: the constants of the materials in use, diameters, films, and how speeds compare.
pub(super) fn check_input(scene: &Scene, runs: &Runs) -> Vec<Remark> {
    let (mut questions, mut perhaps, mut of_roughness) = (vec![], vec![], vec![]);
    for (index, particle) in scene.particles.iter().enumerate() {
        let spheres = runs.spheres_of(index);
        let wet = runs.series_in(spheres);
        // the dry law reads neither density nor diameter
        if wet.is_empty() {
            continue;
        }
        let name = &particle.name;
        questions.extend(DENSITY.question(name, [particle.density].into_iter()));
        let roughness = ROUGHNESS.question(name, particle.roughness.into_iter());
        match scene.model.form().viscous.reads_roughness() {
            true => questions.extend(roughness),
            false => of_roughness.extend(roughness.map(|text| (name.as_str(), text))),
        }
        questions.extend(DIAMETER.question(name, wet.iter().map(|series| series.diameter)));
        let liquids = 0..scene.liquids.len();
        let apart = liquids.filter_map(|liquid| films_apart(scene, runs, index, liquid));
        let apart: Vec<String> = apart.collect();
        if apart.is_empty() {
            let films = wet.iter().flat_map(Series::runs).map(|run| runs.film[run]);
            questions.extend(FILM.question(name, films));
        }
        questions.extend(apart);
        questions.extend(diameters_apart(scene, runs, index));
        if let Some((is_sure, text)) = speeds_apart(scene, runs, index) {
            if is_sure { &mut questions } else { &mut perhaps }.push(text);
        }
    }
    for (index, liquid) in scene.liquids.iter().enumerate() {
        if runs.series.iter().any(|series| series.liquid == index) {
            questions.extend(DENSITY.question(&liquid.name, [liquid.density].into_iter()));
            questions.extend(VISCOSITY.question(&liquid.name, [liquid.viscosity].into_iter()));
        }
    }
    questions.extend(restitutions_too_small(runs));
    let plain = "constants, diameters, films and speeds are such as experiments have";
    let asked = (!runs.is_empty()).then(|| check(remarks::PLAUSIBLE_INPUT, &questions, plain));
    let perhaps = perhaps.into_iter().map(|text| remarks::SPEEDS_PERHAPS.notice(1, text));
    let of_roughness = of_separation(remarks::PLAUSIBLE_INPUT, &of_roughness);
    asked.into_iter().chain(perhaps).chain(of_roughness).collect()
}

/// The same of the roughness of these particles, on which no main number rests where L is one constant, but δc does.
fn of_separation(criterion: Kind, questions: &[(&str, String)]) -> Option<Remark> {
    let texts: Vec<String> = questions.iter().map(|(_, text)| text.clone()).collect();
    let names = questions.iter().map(|(particle, _)| format!("delta_c_m[{particle}]"));
    let asked = check(criterion, &texts, "").concerning(names).forbidding_if(false);
    let next = "correct the roughness, or the unit in its name: δc rests on it, and no main number does";
    (!texts.is_empty()).then(|| asked.then(next))
}

/// The check of what was questioned; `plain` is said where nothing was.
fn check(criterion: Kind, questions: &[String], plain: &str) -> Remark {
    let text = if questions.is_empty() {
        plain.to_owned()
    } else {
        shortened(questions)
    };
    criterion.check(questions.len() as f64, text)
}

/// What to say of restitutions that are a hundredth of what any are.
fn restitutions_too_small(runs: &Runs) -> Option<String> {
    const HUNDREDTH: f64 = 0.0101;
    const FEWEST: usize = 8;
    let [_, largest] = range(runs.restitution.iter().copied())?;
    let rebounds = runs.restitution.iter().filter(|e| **e > 0.0).count();
    (largest < HUNDREDTH && rebounds >= FEWEST).then(|| {
        format!(
            "no restitution is above {}: fractions in a column that is read as per cent?",
            short(largest)
        )
    })
}

/// What to say of films of a particle and a liquid that are in another unit than their neighbours.
fn films_apart(scene: &Scene, runs: &Runs, particle: usize, liquid: usize) -> Option<String> {
    let own = || {
        let series = runs.series_in(runs.spheres_of(particle)).iter();
        let in_liquid = series.filter(|series| series.liquid == liquid);
        in_liquid.flat_map(Series::runs)
    };
    let mut films: Vec<f64> = own().map(|run| runs.film[run]).collect();
    films.sort_unstable_by(f64::total_cmp);
    let median = *films.get(films.len() / 2)?;
    let is_apart = |run: &usize| !(1.0 / APART..APART).contains(&(runs.film[*run] / median));
    let apart = || own().filter(is_apart);
    let films = range(apart().map(|run| runs.film[run]))?;
    let first = runs.places.of(apart().map(|run| runs.row[run]).min()?);
    let ratio = films[0] / median;
    let times = 10f64.powf(ratio.log10().abs().round());
    let side = if ratio < 1.0 { "thinner" } else { "thicker" };
    let slip = match (ratio < 1.0, times) {
        (true, 1000.0) => "mm for µm?",
        (false, 1000.0) => "µm for mm?",
        _ => "another unit?",
    };
    let usual = FILM.usual();
    Some(format!(
        "film of {} runs of {} in {}, the first in {first}, is {} {unit}, some {times} times {side} than their \
         neighbours' {} {unit}: {slip}",
        apart().count(),
        scene.particles[particle].name,
        scene.liquids[liquid].name,
        between(films.map(|film| usual.from_si(film))),
        short(usual.from_si(median)),
        unit = usual.symbol,
    ))
}

/// How speeds stand to those of another unit, of heights in another unit, and of Stokes numbers by another definition; last by
/// what share the ends of the same design may be off, which is less where the factor is one that a design may have, too.
const SLIPS_OF_SPEED: [(f64, &str, f64); 11] = [
    (10.0, "mm/s for cm/s", 0.05),
    (100.0, "cm/s for m/s", 0.05),
    (1000.0, "mm/s for m/s", 0.05),
    (3.6, "km/h for m/s", 0.05),
    (3.281, "ft/s for m/s", 0.05),
    (3.162, "heights in mm for cm", 0.05),
    (31.62, "heights in mm for m", 0.05),
    (9.0, "a Stokes number without its 9", 0.05),
    (
        4.5,
        "a Stokes number with the radius for the diameter and without its 9",
        0.05,
    ),
    (2.237, "miles per hour for m/s", 0.03),
    (
        2.0,
        "another frame rate, or a Stokes number with the radius for the diameter",
        0.03,
    ),
];

/// A smaller factor may be meant.
const SURELY_A_SLIP: f64 = 3.0;

/// The factor and the unit by which one range of speeds becomes another, end by end.
fn slip_between(slow: [f64; 2], fast: [f64; 2]) -> Option<(f64, &'static str)> {
    /// how near the end of one range is where the other begins
    const GOES_ON: f64 = 0.05;
    let off = |factor: f64| {
        let [from, to] = [0, 1].map(|end| (fast[end] / (factor * slow[end]) - 1.0).abs());
        from.max(to)
    };
    let slips = SLIPS_OF_SPEED.into_iter();
    let near = slips.filter(|(factor, _, near)| off(*factor) < *near);
    let found = near.min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
    // where one range begins where the other ends, somebody went on to faster runs
    let goes_on = (fast[0] / slow[1] - 1.0).abs() < GOES_ON;
    (slow[1] > 1.2 * slow[0] && !goes_on).then_some((found.0, found.1))
}

/// What to say of the wet runs of a particle whose diameter is a simple factor from that of its dry ones, as a radius is: of
/// any factor of a unit, and of 2 where no diameter is met both dry and wet.
fn diameters_apart(scene: &Scene, runs: &Runs, particle: usize) -> Option<String> {
    const SLIPS: [(f64, &str); 3] = [
        (2.0, "the radius for the diameter"),
        (10.0, "mm for cm"),
        (25.4, "inches for mm"),
    ];
    const NEAR: f64 = 0.002;
    let spheres = runs.spheres_of(particle);
    let dry = runs.dry_in(spheres.clone()).iter();
    let dry: Vec<f64> = dry.map(|group| group.diameter).collect();
    let wet = runs.series_in(spheres);
    let is_dry = |series: &Series| dry.iter().any(|own| same_diameter(*own, series.diameter));
    let none_is_both = !wet.iter().any(is_dry);
    let slip = |series: &Series| {
        let is_of = |own: f64, factor: f64| ((own / series.diameter).ln().abs() / factor.ln() - 1.0).abs() < NEAR;
        let is_slip = |factor: f64| dry.iter().any(|own| is_of(*own, factor));
        let found = SLIPS.into_iter().find(|(factor, _)| is_slip(*factor));
        found.filter(|(factor, _)| !is_dry(series) && (*factor > 2.0 || none_is_both))
    };
    let apart: Vec<&Series> = wet.iter().filter(|series| slip(series).is_some()).collect();
    let (factor, words) = slip(apart.first()?)?;
    if factor == 2.0 && apart.len() < wet.len() {
        return None;
    }
    let rows = apart.iter().flat_map(|series| series.runs()).map(|run| runs.row[run]);
    let usual = DIAMETER.usual();
    let told = |diameters: &mut dyn Iterator<Item = f64>| range(diameters.map(|d| usual.from_si(d))).map(between);
    Some(format!(
        "diameter of {} wet runs of {}, the first in {}, is {} {unit}, exactly {} times off from the dry ones, {} {unit}: {words}?",
        rows.clone().count(),
        scene.particles[particle].name,
        runs.places.of(rows.min()?),
        told(&mut apart.iter().map(|series| series.diameter))?,
        short(factor),
        told(&mut dry.iter().copied())?,
        unit = usual.symbol,
    ))
}

/// What to say of the runs of a particle whose speeds, dry or in one liquid, are in another unit than its others, and whether
/// that is beyond doubt.
fn speeds_apart(scene: &Scene, runs: &Runs, particle: usize) -> Option<(bool, String)> {
    let spheres = runs.spheres_of(particle);
    let speeds = |runs_of: Range<usize>| runs.impact_speed[runs_of].iter().copied();
    let dry = runs.dry_in(spheres.clone()).iter();
    let dry = range(dry.flat_map(|group| speeds(group.runs())));
    let wet = runs.series_in(spheres);
    let in_liquids = scene.liquids.iter().enumerate().filter_map(|(liquid, of)| {
        let own = wet.iter().filter(|series| series.liquid == liquid);
        let own = range(own.flat_map(|series| speeds(series.runs())))?;
        Some((format!("in {}", of.name), own))
    });
    let dry = dry.map(|speeds| (DRY.to_owned(), speeds));
    let groups: Vec<(String, [f64; 2])> = dry.into_iter().chain(in_liquids).collect();
    let pairs = groups
        .iter()
        .flat_map(|slow| groups.iter().map(move |fast| (slow, fast)));
    // a liquid of its own may well have speeds of its own
    let is_asked = |factor: f64| factor > SURELY_A_SLIP || groups.len() == 2 && groups[0].0 == DRY;
    let found = pairs.map(|(slow, fast)| Some((slow, fast, slip_between(slow.1, fast.1)?)));
    let mut found = found.flatten().filter(|(_, _, (factor, _))| is_asked(*factor));
    let ((slow, from), (fast, to), (factor, slip)) = found.next()?;
    let text = format!(
        "impact speeds of {} {fast}, {} m/s, are {} times those {slow}, {} m/s, from end to end: {slip}?",
        scene.particles[particle].name,
        between(*to),
        short(factor),
        between(*from),
    );
    Some((factor > SURELY_A_SLIP, text))
}

/// A number with its uncertainty.
#[derive(Clone, Copy)]
struct Uncertain<'a> {
    symbol: &'a str,
    /// where it comes from
    source: &'a str,
    value: f64,
    sd: f64,
}

impl Uncertain<'_> {
    /// Its ends.
    fn ends(&self) -> [f64; 2] {
        [self.value - SURE * self.sd, self.value + SURE * self.sd]
    }

    /// What to say of it where it surely lies outside.
    fn question(&self, within: [f64; 2]) -> Option<String> {
        let [least, most] = self.ends();
        let side = if most < within[0] {
            format!("below {}", short(within[0]))
        } else if least > within[1] {
            format!("above {}", short(within[1]))
        } else {
            return None;
        };
        Some(format!(
            "{} = {} by {} is {side}",
            self.symbol,
            short(self.value),
            self.source
        ))
    }
}

/// The check of what came out, by least squares and where it was sampled by the posterior: L, δc, k, C, and the Stokes numbers.
pub(super) fn check_results(scene: &Scene, runs: &Runs, findings: &Findings) -> Vec<Remark> {
    let mut questions = vec![];
    let sampled = |kind: ParameterKind| {
        let name = kind.name(scene, runs);
        let mut all = findings.posterior.as_ref()?.parameters.iter();
        all.find(|own| own.name == name)
    };
    for (index, sphere) in runs.spheres.iter().enumerate() {
        let fitted = fit_of_sphere(&findings.dry, index).map(|dry| &dry.dry_k);
        let symbol = format!("k of {}", sphere.words(scene));
        let both = of_both(&symbol, fitted, sampled(ParameterKind::DryK(index)));
        questions.extend(both.iter().find_map(|k| k.question(DRY_K)));
    }
    let kind = ParameterKind::LUBRICATION_LOG;
    let fitted = findings.energy_balance.as_ref().and_then(|own| own.estimate(kind));
    let both = of_both("L", fitted, sampled(kind));
    let too_small = |l: &Uncertain| l.question([LEAST_LUBRICATION_LOG, f64::INFINITY]);
    questions.extend(both.iter().find_map(too_small));
    let mut of_roughness = vec![];
    for (index, particle) in scene.particles.iter().enumerate() {
        match both.iter().find_map(|l| beyond_films(particle, l, runs, index)) {
            Some((true, text)) => of_roughness.push((particle.name.as_str(), text)),
            Some((false, text)) => questions.push(text),
            None => {}
        }
    }
    let kind = ParameterKind::INERTIAL_PREFACTOR;
    let fitted = findings.energy_balance.as_ref().and_then(|own| own.estimate(kind));
    let both = of_both("C", fitted, sampled(kind));
    questions.extend(
        both.iter()
            .find_map(|c| c.question([f64::NEG_INFINITY, MOST_PREFACTOR])),
    );
    let offsets = findings.noise.as_ref().and_then(|noise| noise.offsets.as_ref());
    let beyond_chance = offsets.filter(|offsets| offsets.test.p < remarks::BEYOND_CHANCE);
    let farthest = beyond_chance.map(|offsets| format!(", the runs of {} as a whole farthest off", offsets.farthest));
    for (kind, symbol, most) in SPREADS {
        let found = of_both(symbol, None, sampled(kind));
        let as_it_is = found.first().map(|own| Uncertain { sd: 0.0, ..*own });
        let question = as_it_is.and_then(|own| own.question([0.0, most]));
        let off = farthest
            .as_deref()
            .filter(|_| kind == ParameterKind::SigmaWet)
            .unwrap_or_default();
        questions.extend(question.map(|question| format!("{question}{off}")));
    }
    let wet = runs.series.iter().flat_map(Series::runs);
    if let Some([least, most]) = range(wet.map(|run| 1.0 / runs.inverse_stokes(run))) {
        let side = match (most < STOKES[0], least > STOKES[1]) {
            (true, _) => Some(format!("below {}", STOKES[0])),
            (_, true) => Some(format!("above {}", STOKES[1])),
            _ => None,
        };
        questions.extend(side.map(|side| format!("St of every wet run is {side} ({})", between([least, most]))));
    }
    let plain = "k, L, C, δc, St and the spreads are such as experiments have";
    let outliers = findings.noise.iter().flat_map(|noise| &noise.outliers);
    let row = |one: &Outlier| {
        let (e, sds) = (one.restitution, one.sds.abs());
        format!("{} (e = {e:.3}, {sds:.1} σ off the law)", one.place)
    };
    let outliers: Vec<String> = outliers.map(row).collect();
    let found = check(remarks::PLAUSIBLE_RESULT, &questions, plain);
    let told = if found.passed || outliers.is_empty() {
        found
    } else {
        let (first, then) = (shortened(&outliers), remarks::PLAUSIBLE_RESULT.next_step);
        found.then(format!("look first at {first}: one wrong row is enough; then {then}"))
    };
    let told = (!runs.is_empty()).then_some(told);
    let of_roughness = of_separation(remarks::PLAUSIBLE_RESULT, &of_roughness);
    told.into_iter().chain(of_roughness).collect()
}

/// A parameter by least squares and by the posterior, as far as there is one.
fn of_both<'a>(symbol: &'a str, fitted: Option<&Estimate>, sampled: Option<&QuantitySummary>) -> Vec<Uncertain<'a>> {
    let of = |source: &'a str, value: f64, sd: Option<f64>| Uncertain {
        symbol,
        source,
        value,
        sd: sd.unwrap_or(0.0),
    };
    let fitted = fitted.and_then(|own| Some(of("least squares", own.value?, own.se)));
    let sampled = sampled.and_then(|own| Some(of("the posterior", own.mean?, own.sd)));
    fitted.into_iter().chain(sampled).collect()
}

/// What to say of δc = ε exp(L) of a particle that is thicker than half of its films or more: the viscous loss sets in inside
/// the film. Without an ε that spheres have of that of the smoothest sphere. And whether it is ε that makes it so: with that of
/// usual spheres it would not be.
fn beyond_films(particle: &Particle, l: &Uncertain, runs: &Runs, index: usize) -> Option<(bool, String)> {
    /// m
    const USUAL: f64 = 10e-6;
    let wet = || runs.series_in(runs.spheres_of(index)).iter().flat_map(Series::runs);
    let mut films: Vec<f64> = wet().map(|run| runs.film[run]).collect();
    films.sort_by(f64::total_cmp);
    let (thickest, middle) = (*films.last()?, films[films.len() / 2]);
    let [smallest, _] = range(wet().map(|run| runs.diameter[run]))?;
    let given = particle
        .roughness
        .filter(|own| ROUGHNESS.hold(ROUGHNESS.usual().from_si(*own)));
    let roughness = given.unwrap_or(SMOOTHEST);
    let critical = |l: f64| roughness * l.exp();
    let least = critical(l.ends()[0]);
    let thickness = |x: f64| format!("{} {}", short(FILM.usual().from_si(x)), FILM.usual().symbol);
    let size = match FILM.usual().from_si(critical(l.value)) {
        size if size.is_finite() => thickness(critical(l.value)),
        _ => format!("ε exp({})", short(l.value)),
    };
    let of_ball = match given {
        Some(_) => String::new(),
        None => format!(" where ε were only {}", thickness(SMOOTHEST)),
    };
    let bounds = [
        ("the sphere", smallest),
        ("every film", thickest),
        ("half of its films", middle),
    ];
    let (than, bound) = bounds.into_iter().find(|(_, bound)| least > *bound)?;
    let is_rough = USUAL.min(roughness) / roughness * least <= middle;
    let text = format!(
        "δc of {} = {size} by {}{of_ball} is larger than {than} ({})",
        particle.name,
        l.source,
        thickness(bound)
    );
    Some((is_rough, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// g/cm³ in the key, kg/m³ in the number.
    #[test]
    fn a_likely_slip_is_named() {
        let value = DENSITY.dimension.usual_to_si(2.15e6);
        let expected =
            "density of PTFE is 2.15e6 kg/m³, outside 300 to 25000 kg/m³: 0.001 times that would do, as where a \
                        unit was mistaken";
        assert_eq!(DENSITY.question("PTFE", [value].into_iter()).as_deref(), Some(expected));
    }

    #[test]
    fn speeds_of_another_unit_are_told_from_those_of_another_design() {
        for (slow, fast, expected) in [
            ([0.4, 1.6], [1.31, 5.3], Some(3.281)),
            ([0.4, 1.6], [0.79, 3.25], Some(2.0)),
            ([0.4, 1.6], [0.84, 3.2], None),
            ([0.5, 2.0], [49.5, 207.0], Some(100.0)),
            ([0.5, 2.0], [2.1, 6.4], None),
            ([0.5, 2.0], [0.5, 2.0], None),
            ([1.0, 1.0], [10.0, 10.0], None),
            // one decade after the other
            ([0.05, 0.5], [0.5, 5.0], None),
        ] {
            let factor = slip_between(slow, fast).map(|(factor, _)| factor);
            assert_eq!(factor, expected, "{slow:?} {fast:?}");
        }
    }

    #[test]
    fn only_what_surely_lies_outside_is_questioned() {
        for (value, sd, is_asked) in [(0.2, 0.01, true), (0.2, 0.06, false), (1.85, 0.0, false)] {
            let l = Uncertain {
                symbol: "L",
                source: "least squares",
                value,
                sd,
            };
            assert_eq!(l.question([LEAST_LUBRICATION_LOG, f64::INFINITY]).is_some(), is_asked);
        }
    }
}
