//! What every mode of a run contributes to what is compared.

use rom_runtime::data::ModelData;

use crate::march::Outcome;
use crate::results::{Channel, Results};
use crate::validate::Setup;
use crate::validate::norms::largest;

/// One mode in the motion of a model with many.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Contribution {
    /// Number of the mode.
    pub(super) number: usize,
    /// Largest part of a quantity that it makes: its largest length over that of the quantity.
    pub(super) share: f64,
    /// Load case and quantity.
    pub(super) of: String,
    /// The same for the mode following its peak generalised force without inertia, `max |q_ddot + omega^2 q| / omega^2`.
    pub(super) driven: f64,
    /// The same for the gyroscopic couplings alone, the magnitudes of the entries of `c` times the largest rates that occur.
    pub(super) coupling: f64,
}

/// Of all modes of a model, from its runs in the load cases; a run that failed tells nothing.
pub(super) fn contributions(
    data: &ModelData,
    runs: &[Option<Outcome>],
    setups: &[Setup],
) -> Vec<Contribution> {
    let m = data.modes.omega.len();
    let mut out: Vec<Contribution> = (0..m)
        .map(|j| Contribution {
            number: data.modes.number[j] as usize,
            share: 0.0,
            of: "nothing".to_owned(),
            driven: 0.0,
            coupling: 0.0,
        })
        .collect();
    for (run, setup) in runs.iter().zip(setups) {
        let Some(run) = run else { continue };
        let Some(q) = run.results.channel("q") else { continue };
        let motion = Motion::new(data, &run.results, q, setup.grid.dt);
        for (name, scale, shape) in quantities(data, &run.results, setup) {
            for (j, contribution) in out.iter_mut().enumerate() {
                // Rates for velocities, amplitudes for displacements.
                let (size, peak) = (shape[j], if name.contains("dR_A") { &motion.q } else { &motion.q_dot });
                let share = size * peak[j] / scale;
                if share > contribution.share {
                    contribution.share = share;
                    contribution.of = format!("{name} in {}", setup.case.name);
                    let static_share =
                        size / scale * if name.contains("dR_A") { 1.0 } else { data.modes.omega[j] };
                    contribution.driven = static_share * motion.drive[j];
                    contribution.coupling = static_share * motion.coupling[j];
                }
            }
        }
    }
    out
}

/// Name, largest length and what a unit of each mode makes of it, of everything that is compared.
fn quantities(data: &ModelData, results: &Results, setup: &Setup) -> Vec<(String, f64, Vec<f64>)> {
    let m = data.modes.omega.len();
    let rows = |matrix: &[f64], first: usize, j: usize| {
        (first..first + 3).map(|k| matrix[k * m + j].powi(2)).sum::<f64>().sqrt()
    };
    let mut out = Vec::new();
    let mut add = |name: String, shape: Vec<f64>| {
        let scale = results.channel(&name).map_or(0.0, largest);
        if scale > 0.0 {
            out.push((name, scale, shape));
        }
    };
    add("v_G".to_owned(), (0..m).map(|j| rows(&data.modes.phi_r, 0, j)).collect());
    add("w_G".to_owned(), (0..m).map(|j| rows(&data.modes.phi_r, 3, j)).collect());
    for (index, name) in &setup.points {
        let phi = &data.points[*index].phi_translation;
        add(format!("{name}.dR_A"), (0..m).map(|j| rows(phi, 0, j)).collect());
    }
    out
}

/// Peaks over a run - each (m).
struct Motion {
    q: Vec<f64>,
    q_dot: Vec<f64>,
    /// `max |q_ddot + omega^2 q| / omega^2`.
    drive: Vec<f64>,
    /// `sum |c_jlr| max |u_l| max |beta_r| / omega_j^2`.
    coupling: Vec<f64>,
}

impl Motion {
    fn new(data: &ModelData, results: &Results, q: &Channel, dt: f64) -> Self {
        let m = data.modes.omega.len();
        let peak = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |max: f64, v| max.max(v.abs()));
        let (mut amplitude, mut rate, mut drive) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..m {
            let history: Vec<f64> = q.column(j).collect();
            let omega2 = data.modes.omega[j].powi(2);
            amplitude.push(peak(&mut history.iter().copied()));
            rate.push(peak(&mut history.windows(3).map(|w| (w[2] - w[0]) / (2.0 * dt))));
            let force = |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) / (dt * dt * omega2) + w[1];
            drive.push(peak(&mut history.windows(3).map(force)));
        }
        let velocity: Vec<f64> = ["v_A", "w_A"]
            .iter()
            .flat_map(|name| (0..3).map(move |k| (name, k)))
            .map(|(name, k)| results.channel(name).map_or(0.0, |c| peak(&mut c.column(k))))
            .collect();
        let u: Vec<f64> = rate.iter().chain(&velocity).copied().collect();
        let mut coupling = vec![0.0; m];
        for entry in 0..data.c.value.len() {
            let (i, l, r) = (data.c.i[entry] as usize, data.c.l[entry] as usize, data.c.r[entry] as usize);
            if i < m {
                coupling[i] += data.c.value[entry].abs() * u[l] * velocity[r] / data.modes.omega[i].powi(2);
            }
        }
        Self { q: amplitude, q_dot: rate, drive, coupling }
    }
}
