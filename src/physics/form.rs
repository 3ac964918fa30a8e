//! Says which terms an energy balance holds, and in which forms.

use super::bridge::Bridge;
use super::coefficient::{Coefficient, Coefficients, LogNormal, Parameter};
use super::dry::{speed_root, Order, REFERENCE_SPEED};
use super::inertia::{Inertia, FILM_SCALE, PREFACTOR};
use super::loss::{AtFilm, Fixed, Loss, Setting};
use super::viscous::{slope_lubrication_log, Viscous, LUBRICATION_LOG, RUPTURE_SCALE};

/// Speed at which e_dry enters the energy balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrySpeed {
    /// one reference speed for every run, m/s (the paper: 2 m/s)
    Reference(f64),
    /// each run's own impact speed
    Impact,
}

impl DrySpeed {
    /// The speed to use for a run at `impact_speed`, m/s.
    pub fn of(self, impact_speed: f64) -> f64 {
        match self {
            DrySpeed::Reference(speed) => speed,
            DrySpeed::Impact => impact_speed,
        }
    }

    /// The speed at which e_inf and St_c are quoted, m/s.
    pub fn reference(self) -> f64 {
        self.of(REFERENCE_SPEED)
    }
}

/// The terms an energy balance holds, and their forms: r = e_dry² − C ρ̃ g(δ̃) − 4 L/St − κ/v², each as far as it is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// form of the inertial loss
    pub inertia: Inertia,
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// form of the viscous loss
    pub viscous: Viscous,
    /// whether the rupture of the bridge is held, where the liquid has a surface tension
    pub bridge: Bridge,
    /// order of the dry law
    pub dry: Order,
}

impl Form {
    /// The paper's balance: the viscous loss with one L, no bridge, the dry law to first order.
    pub fn new(inertia: Inertia, dry_speed: DrySpeed) -> Form {
        Form {
            inertia,
            dry_speed,
            viscous: Viscous::Constant,
            bridge: Bridge(false),
            dry: Order::First,
        }
    }

    /// The losses, in the order of their parameters in files.
    pub fn losses(&self) -> [&dyn Loss; 3] {
        [&self.viscous, &self.inertia, &self.bridge]
    }

    /// What its losses take at a film ratio, in the same order.
    pub fn at(&self, film_ratio: f64, values: &Coefficients) -> [AtFilm; 3] {
        self.losses().map(|loss| loss.at(film_ratio, values))
    }

    /// The parameters its losses have, in the order of files.
    pub fn coefficients(&self) -> impl Iterator<Item = Coefficient> + '_ {
        self.losses().into_iter().flat_map(|loss| loss.coefficients()).copied()
    }

    /// Whether a loss of it has this parameter.
    pub fn has(&self, coefficient: Coefficient) -> bool {
        self.coefficients().any(|own| own == coefficient)
    }

    /// What its losses take of a setting that no parameter moves; `None` if nothing, whatever the setting.
    pub fn fixed(&self, setting: &Setting) -> Option<Fixed> {
        let each = self.losses().into_iter().filter_map(|loss| loss.fixed(setting));
        each.reduce(|a, b| Fixed {
            over_speed: a.over_speed + b.over_speed,
            over_square: a.over_square + b.over_square,
        })
    }

    /// The part of L, the losses over 4/St, that no parameter moves.
    pub fn fixed_over_stokes(&self, setting: &Setting) -> f64 {
        // the coefficient of 1/v over that of 4/St
        let over = |fixed: Fixed| fixed.over_speed / slope_lubrication_log(setting.stokes(1.0));
        self.fixed(setting).map_or(0.0, over)
    }

    /// What is believed of a parameter before any run.
    pub fn prior(&self, coefficient: Coefficient) -> LogNormal {
        match coefficient {
            Coefficient::InertialPrefactor => self.inertia.prefactor_prior(),
            other => other.describe().prior,
        }
    }

    /// The energy kept, as a formula; `film` is how the text calls the film ratio.
    pub fn formula(&self, film: &str) -> String {
        let mut text = "e_dry²".to_owned();
        // the inertial loss is read first
        let [viscous, inertia, bridge] = self.losses();
        for loss in [inertia, viscous, bridge]
            .into_iter()
            .filter_map(|loss| loss.formula(film))
        {
            text.push_str(" − ");
            text.push_str(&loss);
        }
        text
    }

    /// What the symbols of the formula stand for, loss by loss.
    pub fn definitions(&self, film: &str) -> Vec<String> {
        let each = self.losses().into_iter();
        each.filter_map(|loss| loss.definition(film)).collect()
    }

    /// v^(1/5) at the dry speed in use, from that of the impact speed.
    pub fn dry_root(&self, impact_root: f64) -> f64 {
        match self.dry_speed {
            DrySpeed::Reference(speed) => speed_root(speed),
            DrySpeed::Impact => impact_root,
        }
    }
}

impl Coefficient {
    /// What it is.
    pub fn describe(self) -> &'static Parameter {
        match self {
            Coefficient::LubricationLog => &LUBRICATION_LOG,
            Coefficient::RuptureScale => &RUPTURE_SCALE,
            Coefficient::InertialPrefactor => &PREFACTOR,
            Coefficient::FilmScale => &FILM_SCALE,
        }
    }
}

/// What a balance may hold beyond e_dry² to first order at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "cli", serde(rename_all = "snake_case"))]
pub enum Term {
    /// C ρ̃ g(δ̃)
    Inertia,
    /// 4 L/St
    Viscous,
    /// e_dry at each run's own speed
    OwnDrySpeed,
    /// κ/v²
    Bridge,
    /// (3/5) k² v^(2/5)
    DrySecondOrder,
}

impl Term {
    /// Every term, in the order of reports.
    pub const ALL: [Term; 5] = [
        Term::Inertia,
        Term::Viscous,
        Term::OwnDrySpeed,
        Term::Bridge,
        Term::DrySecondOrder,
    ];

    /// Those that a scene's list of terms can name; a key of its own sets the dry speed.
    pub const LISTED: [Term; 4] = [Term::Inertia, Term::Viscous, Term::Bridge, Term::DrySecondOrder];

    /// Its word in scenes and files.
    pub fn name(self) -> &'static str {
        match self {
            Term::Inertia => "inertia",
            Term::Viscous => "viscous",
            Term::OwnDrySpeed => "own_dry_speed",
            Term::Bridge => "bridge",
            Term::DrySecondOrder => "dry_second_order",
        }
    }

    /// What it is called in a text.
    pub fn in_words(self) -> &'static str {
        match self {
            Term::Inertia => "inertia of the liquid",
            Term::Viscous => "viscous loss",
            Term::OwnDrySpeed => "e_dry at the run's own speed",
            Term::Bridge => "rupture of the bridge",
            Term::DrySecondOrder => "second order of the dry law",
        }
    }

    /// Whether a form holds it.
    pub fn is_held(self, form: Form) -> bool {
        match self {
            Term::Inertia => form.inertia != Inertia::None,
            Term::Viscous => form.viscous != Viscous::None,
            Term::OwnDrySpeed => form.dry_speed == DrySpeed::Impact,
            Term::Bridge => form.bridge.0,
            Term::DrySecondOrder => form.dry == Order::Second,
        }
    }

    /// The form with this term held where it was not, and left out where it was.
    pub fn toggled(self, mut form: Form) -> Form {
        let held = self.is_held(form);
        match self {
            Term::Inertia if held => form.inertia = Inertia::None,
            Term::Inertia => form.inertia = Inertia::Stepwise,
            Term::Viscous if held => form.viscous = Viscous::None,
            Term::Viscous => form.viscous = Viscous::Constant,
            Term::OwnDrySpeed if held => form.dry_speed = DrySpeed::Reference(REFERENCE_SPEED),
            Term::OwnDrySpeed => form.dry_speed = DrySpeed::Impact,
            Term::Bridge => form.bridge = Bridge(!held),
            Term::DrySecondOrder if held => form.dry = Order::First,
            Term::DrySecondOrder => form.dry = Order::Second,
        }
        form
    }

    /// Whether a parameter is this term's own: leaving it out of a form leaves the parameter out, too.
    pub fn owns(self, coefficient: Coefficient, form: Form) -> bool {
        let held = if self.is_held(form) { form } else { self.toggled(form) };
        held.has(coefficient) && !self.toggled(held).has(coefficient)
    }
}

impl Form {
    /// The terms a scene's list would name.
    pub fn terms(self) -> Vec<Term> {
        Term::LISTED.into_iter().filter(|term| term.is_held(self)).collect()
    }

    /// The same with exactly these of the terms a list can name; inertia and viscous loss keep their forms, also where
    /// that is none.
    pub fn with_terms(self, terms: &[Term]) -> Form {
        let differs = |form: Form, term: &Term| match (terms.contains(term), term.is_held(form)) {
            (true, false) => !matches!(term, Term::Inertia | Term::Viscous),
            (listed, held) => listed != held,
        };
        let mut form = self;
        for term in Term::LISTED {
            if differs(form, &term) {
                form = term.toggled(form);
            }
        }
        form
    }
}
