//! Moves the minimum of the energy balance with the constants, without fitting again.

use crate::findings::balance::{blocks, e_inf2, errors, in_standard_errors, known, place_of, Held};
use crate::findings::dry::FittedDry;
use crate::findings::energy::density_ratio;
use crate::inference::balance::{refit_balance, Balance, Block};
use crate::inference::effective_variance::{roots, weigh, Weighted};
use crate::inference::least_squares::Minimum;
use crate::physics::viscous;
use crate::runs::Runs;
use crate::scene::Scene;

/// The balance of some of the runs, to be moved a little to either side.
pub(super) struct Movable<'h> {
    held: &'h Held,
    known: Vec<(usize, (f64, f64))>,
    dry_k: Vec<(f64, f64)>,
    share: f64,
    /// roots of the runs' weights; empty where they carry no errors
    roots: Vec<f64>,
    minimum: Minimum,
}

/// What a balance says at parameters of its own.
pub(super) struct Moved {
    /// the parameters, in the order of `EnergyBalance::parameters`
    pub(super) parameters: Vec<f64>,
    /// e_inf and St_c of each film group; NaN where nothing is left for e_inf
    pub(super) derived: Vec<[f64; 2]>,
}

impl<'h> Movable<'h> {
    /// Fits the balance again from where it ended, its form and the weight of the dry runs kept; `share` of the rebounds
    /// are among these runs. `None` unless that converges on a minimum with standard errors.
    pub(super) fn new(scene: &Scene, runs: &Runs, dry: &[FittedDry], held: &'h Held, share: f64) -> Option<Self> {
        let known = known(runs, dry);
        let dry_k: Vec<(f64, f64)> = known.iter().map(|(_, k)| *k).collect();
        let place = |particle: usize| place_of(&known, particle);
        let blocks = blocks(scene, runs, place);
        let balance = balance_of(held, &blocks, &dry_k, share);
        let mut fit = refit_balance(&balance, &[], &held.parameters);
        let mut of_runs = vec![];
        if let Some(errors) = errors(runs, place) {
            let in_errors = in_standard_errors(balance.clone(), share);
            let weighed = weigh(&errors.erring(), fit.clone(), |_| in_errors.clone());
            if let Some(weighing) = weighed.1 {
                let mut variance = weighing.variance;
                variance.resize(
                    in_errors.blocks.iter().map(|b| b.restitution.len()).sum::<usize>() + dry_k.len(),
                    1.0,
                );
                of_runs = roots(&variance).0;
                fit = refit_balance(&in_errors, &of_runs, &held.parameters);
            }
        }
        let weighted = Weighted {
            problem: &balance,
            roots: &of_runs,
        };
        let minimum = Minimum::new(&weighted, &fit)?;
        Some(Movable {
            held,
            known,
            dry_k,
            share,
            roots: of_runs,
            minimum,
        })
    }

    /// What the balance says of two scenes and their runs that lie as far on either side: of the first, of the second.
    pub(super) fn at(&self, settings: [(&Scene, &Runs); 2]) -> Option<[Moved; 2]> {
        let place = |particle: usize| place_of(&self.known, particle);
        let [first, second] = settings.map(|(scene, runs)| blocks(scene, runs, place));
        let balance = |blocks| balance_of(self.held, blocks, &self.dry_k, self.share);
        let (first, second) = (balance(&first), balance(&second));
        let weighted = [&first, &second].map(|problem| Weighted {
            problem,
            roots: &self.roots,
        });
        let minima = self.minimum.of_neighbours(&weighted[0], &weighted[1])?;
        let [of_first, of_second] = minima;
        Some([
            self.tell(settings[0], &first, of_first),
            self.tell(settings[1], &second, of_second),
        ])
    }

    fn tell(&self, (scene, runs): (&Scene, &Runs), balance: &Balance, parameters: Vec<f64>) -> Moved {
        let derived = runs.film_groups.iter().map(|group| {
            let Some(place) = place_of(&self.known, group.particle) else {
                return [f64::NAN; 2];
            };
            let density_ratio = density_ratio(scene, group.particle, &runs.series[group.series.clone()]);
            let e_inf = e_inf2(scene, balance, place, &parameters, (density_ratio, group.film_ratio)).sqrt();
            let st_c = viscous::st_c(balance.unpack(&parameters).0, e_inf);
            [e_inf, if balance.form.viscous { st_c } else { f64::NAN }]
        });
        Moved {
            derived: derived.collect(),
            parameters,
        }
    }
}

fn balance_of<'b>(held: &Held, blocks: &'b [Block], dry_k: &'b [(f64, f64)], share: f64) -> Balance<'b> {
    Balance {
        blocks,
        form: held.form,
        dry_k,
        // fewer wet runs are held by as much less
        spread: held.spread * share.sqrt(),
    }
}
