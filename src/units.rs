//! Converts between the units a key or a column may carry and the SI values used everywhere inside.
//!
//! This is the only file with powers of ten. A unit is part of a name: `diameter_mm` is the base name
//! `diameter` with the suffix `_mm`.

/// A kind of quantity, with the units in which a file may give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// metre
    Length,
    /// metre; of films and roughness, which are usually given in µm
    Thickness,
    /// metre per second
    Speed,
    /// kilogram per cubic metre
    Density,
    /// pascal second (dynamic viscosity)
    Viscosity,
    /// newton per metre
    SurfaceTension,
    /// second
    Time,
    /// hertz
    Frequency,
    /// pixels of an image per metre
    ImageScale,
    /// a plain number that may be given in per cent
    Share,
    /// a plain number: its names carry no suffix
    One,
}

/// Smallest and largest magnitude a file may give, in SI: products and quotients of a few quantities then neither
/// overflow nor vanish. Every physical quantity lies far inside.
pub const MAGNITUDES: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// What to say of a number outside [`MAGNITUDES`].
pub const MAGNITUDE_EXPECTED: &str = "a magnitude from 1e-60 to 1e60 in SI units";

/// One way to write a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// what a key or a column ends with, underscore included
    pub suffix: &'static str,
    /// how it is printed
    pub symbol: &'static str,
    /// what a number in it is multiplied by and then divided by in SI
    scale: [f64; 2],
}

/// Powers of ten from one upwards are exact in f64; their inverses are not, so a unit says what it divides by.
const fn unit(suffix: &'static str, symbol: &'static str, scale: [f64; 2]) -> Unit {
    Unit { suffix, symbol, scale }
}

const MILLIMETRE: Unit = unit("_mm", "mm", [1.0, 1e3]);
const MICROMETRE: Unit = unit("_um", "µm", [1.0, 1e6]);
const CENTIMETRE: Unit = unit("_cm", "cm", [1.0, 1e2]);
const METRE: Unit = unit("_m", "m", [1.0, 1.0]);
const LENGTH: &[Unit] = &[MILLIMETRE, MICROMETRE, CENTIMETRE, METRE];
const THICKNESS: &[Unit] = &[MICROMETRE, MILLIMETRE, CENTIMETRE, METRE];
const SPEED: &[Unit] = &[
    unit("_m_s", "m/s", [1.0, 1.0]),
    unit("_cm_s", "cm/s", [1.0, 1e2]),
    unit("_mm_s", "mm/s", [1.0, 1e3]),
];
const DENSITY: &[Unit] = &[unit("_kg_m3", "kg/m³", [1.0, 1.0]), unit("_g_cm3", "g/cm³", [1e3, 1.0])];
const VISCOSITY: &[Unit] = &[unit("_mPa_s", "mPa s", [1.0, 1e3]), unit("_Pa_s", "Pa s", [1.0, 1.0])];
const SURFACE_TENSION: &[Unit] = &[unit("_mN_m", "mN/m", [1.0, 1e3]), unit("_N_m", "N/m", [1.0, 1.0])];
const TIME: &[Unit] = &[unit("_s", "s", [1.0, 1.0]), unit("_ms", "ms", [1.0, 1e3])];
const FREQUENCY: &[Unit] = &[unit("_Hz", "Hz", [1.0, 1.0]), unit("_kHz", "kHz", [1e3, 1.0])];
const IMAGE_SCALE: &[Unit] = &[
    unit("_px_per_mm", "px/mm", [1e3, 1.0]),
    unit("_px_per_m", "px/m", [1.0, 1.0]),
];
const SHARE: &[Unit] = &[unit("", "", [1.0, 1.0]), unit("_percent", "%", [1.0, 1e2])];
const ONE: &[Unit] = &[unit("", "", [1.0, 1.0])];

impl Dimension {
    /// Every unit in which a file may give this kind of quantity; the usual one first.
    pub fn units(self) -> &'static [Unit] {
        match self {
            Dimension::Length => LENGTH,
            Dimension::Thickness => THICKNESS,
            Dimension::Speed => SPEED,
            Dimension::Density => DENSITY,
            Dimension::Viscosity => VISCOSITY,
            Dimension::SurfaceTension => SURFACE_TENSION,
            Dimension::Time => TIME,
            Dimension::Frequency => FREQUENCY,
            Dimension::ImageScale => IMAGE_SCALE,
            Dimension::Share => SHARE,
            Dimension::One => ONE,
        }
    }

    /// The unit of a name that ends so.
    pub fn unit(self, suffix: &str) -> Option<&'static Unit> {
        self.units().iter().find(|unit| unit.suffix == suffix)
    }

    /// Every name of this base that a quantity can have in a file, each with its unit; the usual one first.
    pub fn names(self, base: &str) -> impl Iterator<Item = (String, &'static Unit)> + '_ {
        let units = self.units().iter();
        units.map(move |unit| (format!("{base}{}", unit.suffix), unit))
    }

    /// The SI value of a number written in the usual unit.
    pub fn usual_to_si(self, value: f64) -> f64 {
        self.units()[0].to_si(value)
    }
}

/// Every name a quantity can have in a file, as `a`, `b` or `c`.
pub fn names_in_words(base: &str, dimension: Dimension) -> String {
    let names = dimension.names(base).map(|(name, _)| format!("`{name}`"));
    let names: Vec<String> = names.collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

impl Unit {
    /// The SI value of a number written in this unit.
    pub fn to_si(&self, value: f64) -> f64 {
        let [times, over] = self.scale;
        value * times / over
    }

    /// The number that stands for an SI value in this unit.
    pub fn from_si(&self, value: f64) -> f64 {
        let [times, over] = self.scale;
        value * over / times
    }
}

/// Millimetres of a length in metres, for print.
pub fn millimetres(metres: f64) -> f64 {
    metres * 1e3
}

/// Micrometres of a length in metres, for print.
pub fn micrometres(metres: f64) -> f64 {
    metres * 1e6
}

/// Pixels per millimetre of a scale in pixels per metre, for print.
pub fn pixels_per_millimetre(pixels_per_metre: f64) -> f64 {
    pixels_per_metre / 1e3
}

/// Milliseconds of a time in seconds, for print.
pub fn milliseconds(seconds: f64) -> f64 {
    seconds * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal but for the last bit, which a change of unit may move.
    fn same(a: f64, b: f64) -> bool {
        (a - b).abs() <= f64::EPSILON * b.abs()
    }

    #[test]
    fn the_units_agree_with_each_other() {
        assert!(same(LENGTH[2].to_si(25.0), LENGTH[0].to_si(250.0)));
        assert!(same(THICKNESS[0].to_si(250.0), LENGTH[0].to_si(0.25)));
        assert!(same(SPEED[1].to_si(150.0), SPEED[2].to_si(1500.0)));
        assert!(same(DENSITY[1].to_si(2.15), 2150.0));
        assert!(same(VISCOSITY[0].to_si(9.3), VISCOSITY[1].to_si(0.0093)));
        assert!(same(SHARE[1].to_si(86.3), 0.863));
        assert!(same(SURFACE_TENSION[0].to_si(20.1), SURFACE_TENSION[1].to_si(0.0201)));
    }
}
