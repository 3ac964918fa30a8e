//! Finds what findings hold by its name.

use wetcor::findings::balance::EnergyBalance;
use wetcor::findings::estimate::Estimate;
use wetcor::findings::estimates::EstimateRow;
use wetcor::findings::scaling::Scaling;
use wetcor::findings::Findings;
use wetcor::remark::Remark;
use wetcor::scene::WetLaw;

pub trait Told {
    fn findings(&self) -> &Findings;

    /// A check by its code, if it was made.
    fn made(&self, code: &str) -> Option<&Remark> {
        self.findings().checks().find(|check| check.code == code)
    }

    /// A check that must have been made.
    fn check(&self, code: &str) -> &Remark {
        self.made(code).unwrap_or_else(|| panic!("no check {code}"))
    }

    /// Whether a check failed that forbids quoting.
    fn forbids(&self, code: &str) -> bool {
        let mut checks = self.findings().checks();
        checks.any(|check| check.code == code && check.gates() && !check.passed)
    }

    fn notice(&self, code: &str) -> Option<&Remark> {
        self.findings().notices().find(|notice| notice.code == code)
    }

    fn tells(&self, code: &str) -> bool {
        self.notice(code).is_some()
    }

    /// The energy balance of dry and wet runs.
    fn balance(&self) -> &EnergyBalance {
        self.findings().energy_balance.as_ref().expect("dry and wet runs")
    }

    /// A parameter of it.
    fn fitted(&self, name: &str) -> &Estimate {
        let mut all = self.balance().parameters.iter();
        let own = all.find(|own| own.name == name);
        &own.unwrap_or_else(|| panic!("no parameter {name}")).estimate
    }

    /// The square-root law of the first film ratio.
    fn square_root(&self) -> &Scaling {
        let of_film = |row: &&Scaling| row.law == WetLaw::Sqrt && row.film_ratio.is_some();
        self.findings().scaling.iter().find(of_film).expect("wet runs")
    }

    fn main_number(&self, name: &str) -> &EstimateRow {
        let mut all = self.findings().main.parameters.iter();
        let own = all.find(|own| own.name() == name);
        own.unwrap_or_else(|| panic!("no main number {name}"))
    }
}

impl Told for Findings {
    fn findings(&self) -> &Findings {
        self
    }
}
