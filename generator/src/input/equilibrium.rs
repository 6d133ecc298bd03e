//! Gravity and the equilibrium to be modelled about: as written, and as the generator takes them.

use nalgebra::{UnitQuaternion, Vector3};
use rom_runtime::loads::LoadCase;

use super::distributed::DistributedFile;
use super::loads::{LoadContext, LoadFile};
use super::read::{Reader, table, words};
use super::values::{At, Count, List, Number, Text, Triple};
use crate::equilibrium::trim::{About, Component, Trim, Unknown, WhenUnbalanced};
use crate::equilibrium::{EquilibriumSettings, WhenUnstable};
use crate::math::so3::exp_quaternion;

table! {
    /// Uniform gravity, which acts on the whole structure in the equilibrium and in every run.
    GravityFile {
        /// Acceleration of free fall in G, m/s^2.
        acceleration: Triple,
    }
}

table! {
    /// The loaded equilibrium that the structure is modelled about. Its loads go on acting in every run.
    EquilibriumFile {
        /// Loads in balance with the elastic forces and gravity, taken at t = 0 and constant from then on.
        loads: Option<List<LoadFile>>,
        /// Loads per length along members, taken likewise.
        distributed_loads: Option<List<DistributedFile>>,
        /// Attitude of the structure in G.
        attitude: Option<AttitudeFile>,
        /// Factors on named loads that are solved for so that components of the reaction at the reference node vanish.
        balance: Option<List<BalanceFile>>,
        /// Load steps to begin with; they are halved and doubled as needed. Default 1.
        load_steps: Option<Count>,
        /// Last correction of Newton's iteration relative to the size of the structure, 1e-14 to 1e-3. Default 1e-9.
        tolerance: Option<Number>,
        /// What to do about an equilibrium that the structure would leave by itself with its reference node held.
        unstable: Option<UnstableFile>,
        /// What to do about a reaction at the reference node that is left: the structure would move off by itself.
        unbalanced: Option<UnbalancedFile>,
    }
}

table! {
    /// Turns from the axes of G to those of A: yaw about z, then pitch about the turned y, then roll about the turned x, rad. Each 0 by
    /// default.
    AttitudeFile {
        /// Last turn, about x, rad.
        roll: Option<Number>,
        /// Second turn, about y, rad.
        pitch: Option<Number>,
        /// First turn, about z, rad.
        yaw: Option<Number>,
    }
}

impl AttitudeFile {
    /// Components in A to components in G.
    pub(crate) fn quaternion(&self) -> UnitQuaternion<f64> {
        let turn = |axis: Vector3<f64>, angle: &Option<Number>| {
            exp_quaternion(&(axis * angle.as_ref().map_or(0.0, |a| a.value)))
        };
        turn(Vector3::z(), &self.yaw) * turn(Vector3::y(), &self.pitch) * turn(Vector3::x(), &self.roll)
    }
}

table! {
    /// A factor to be solved for.
    BalanceFile {
        /// Name of the loads that it multiplies.
        load: Text,
        /// Component of the reaction at the reference node that is to vanish; each load and each component once.
        component: ComponentFile,
        /// Axes of the component. Default: those of A.
        axes: Option<AxesFile>,
    }
}

words! {
    /// Component of a force, or of a moment about the reference node.
    ComponentFile {
        /// Force along x.
        "force-x" => ForceX,
        /// Force along y.
        "force-y" => ForceY,
        /// Force along z.
        "force-z" => ForceZ,
        /// Moment about x.
        "moment-x" => MomentX,
        /// Moment about y.
        "moment-y" => MomentY,
        /// Moment about z.
        "moment-z" => MomentZ,
    }
}

words! {
    /// Axes of components.
    AxesFile {
        /// Those of the body frame A.
        "body" => Body,
        /// Those of the inertial frame G.
        "inertial" => Inertial,
    }
}

words! {
    /// What to do about an unstable equilibrium.
    UnstableFile {
        /// An error that says where stability is lost (default).
        "refuse" => Refuse,
        /// Follow the path beyond.
        "accept" => Accept,
    }
}

words! {
    /// What to do about an equilibrium that is not in balance with itself.
    UnbalancedFile {
        /// An error that says what is missing (default).
        "refuse" => Refuse,
        /// Say so and carry on.
        "warn" => Warn,
    }
}

/// Checks the equilibrium against the points and members of the structure.
pub(crate) fn resolve_equilibrium(
    file: &EquilibriumFile,
    context: &LoadContext<'_>,
    reader: &mut Reader,
) -> Option<Trim> {
    let no_loads: &[Option<LoadFile>] = &[];
    let given = file.loads.as_ref().map_or(no_loads, |list| &list.items);
    let loads = context.loads(given, reader);
    let distributed = context.distributed(file.distributed_loads.as_ref(), reader);
    let spread = file.distributed_loads.iter().flat_map(|list| &list.items);
    let names: Vec<String> = given
        .iter()
        .map(|load| load.as_ref()?.name.as_ref())
        .chain(spread.map(|load| load.as_ref()?.name.as_ref()))
        .map(|name| name.map(|name| name.value.clone()).unwrap_or_default())
        .collect();
    let balance: Vec<Option<Unknown>> = file
        .balance
        .iter()
        .flat_map(|list| &list.items)
        .map(|entry| resolve_unknown(entry.as_ref()?, &names, reader))
        .collect();
    let balance = balance.into_iter().collect::<Option<Vec<_>>>();
    check_distinct(file, balance.as_deref().unwrap_or_default(), reader);
    let tolerance = resolve_tolerance(file.tolerance.as_ref(), reader);
    let settings = EquilibriumSettings {
        attitude: file.attitude.as_ref().map_or(UnitQuaternion::identity(), AttitudeFile::quaternion),
        load_steps: file.load_steps.as_ref().map_or(1, |n| n.value.min(MOST_STEPS)),
        tolerance: tolerance?,
        when_unstable: match file.unstable {
            Some(UnstableFile::Accept) => WhenUnstable::Accept,
            _ => WhenUnstable::Refuse,
        },
        ..EquilibriumSettings::default()
    };
    let when_unbalanced = match file.unbalanced {
        Some(UnbalancedFile::Warn) => WhenUnbalanced::Warn,
        _ => WhenUnbalanced::Refuse,
    };
    let case = LoadCase { loads: loads?, distributed: distributed?, ..LoadCase::empty("equilibrium") };
    Some(Trim { case, names, settings, balance: balance?, when_unbalanced, about: About::Equilibrium })
}

/// Most load steps that can be asked for.
const MOST_STEPS: usize = 100_000;

fn resolve_unknown(entry: &BalanceFile, names: &[String], reader: &mut Reader) -> Option<Unknown> {
    let At { value: load, span } = &entry.load;
    if load.is_empty() || !names.contains(load) {
        let known = names.iter().map(String::as_str).filter(|name| !name.is_empty());
        let help = super::diagnostic::suggest(load, "names of loads", known);
        let message = format!("no load of the equilibrium is named `{}`", load.escape_debug());
        return reader.error_help(*span, message, help);
    }
    let index = match entry.component {
        ComponentFile::ForceX => 0,
        ComponentFile::ForceY => 1,
        ComponentFile::ForceZ => 2,
        ComponentFile::MomentX => 3,
        ComponentFile::MomentY => 4,
        ComponentFile::MomentZ => 5,
    };
    let inertial = entry.axes == Some(AxesFile::Inertial);
    Some(Unknown { load: load.clone(), component: Component { index, inertial } })
}

/// As many equations as unknowns: every load and every component once.
fn check_distinct(file: &EquilibriumFile, balance: &[Unknown], reader: &mut Reader) {
    let entries = file.balance.iter().flat_map(|list| &list.items).flatten();
    for (k, (unknown, entry)) in balance.iter().zip(entries).enumerate() {
        if balance[..k].iter().any(|other| other.load == unknown.load) {
            let message = format!("the factor on `{}` is solved for already", unknown.load.escape_debug());
            reader.error_help::<()>(entry.load.span, message, "one component for each name of loads");
        }
        if balance[..k].iter().any(|other| other.component == unknown.component) {
            let message = format!("{} is cancelled by another load already", unknown.component);
            reader.error_help::<()>(entry.span, message, "one load for each component");
        }
    }
}

fn resolve_tolerance(tolerance: Option<&Number>, reader: &mut Reader) -> Option<f64> {
    match tolerance {
        None => Some(EquilibriumSettings::default().tolerance),
        Some(given) if (1e-14..=1e-3).contains(&given.value) => Some(given.value),
        Some(given) => {
            reader.error(given.span, format!("the tolerance is {}, expected 1e-14 to 1e-3", given.value))
        }
    }
}
