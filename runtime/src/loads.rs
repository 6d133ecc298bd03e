//! Loads as data: where they act, in which frame they are constant and how they vary with time.

use alloc::{string::String, vec::Vec};
use serde::{Deserialize, Serialize};

use crate::base_motion::BaseMotion;

/// Frame in which the components of a load are constant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LoadFrame {
    /// Constant in the inertial frame G.
    Dead,
    /// Constant in the body frame A.
    Body,
    /// Constant in a section frame B attached to the point's node.
    Follower {
        /// Section frame at the point, node frame from section frame (rotation matrix `E`, row-major).
        section: [[f64; 3]; 3],
    },
}

/// One force and/or moment on a named point: `time(t)` times the vectors below.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Index into the model's points.
    pub point: u32,
    /// Frame of the components.
    pub frame: LoadFrame,
    /// Force per unit of the time function, N, in `frame`.
    pub force: [f64; 3],
    /// Moment per unit of the time function, N m, in `frame`.
    pub moment: [f64; 3],
    /// Factor over time.
    pub time: crate::time::TimeFunction,
}

/// Frame in which the components of a distributed load are constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DistributedFrame {
    /// The inertial frame G.
    Dead,
    /// The body frame A.
    Body,
    /// The axes of every section.
    Follower,
}

/// A force and/or a moment per length along a member: `time(t)` times the vectors below, which are integrated already. Three stations an
/// element, at its Gauss points, carry it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DistributedLoad {
    /// Index of the member in the model's lines.
    pub member: u32,
    /// Frame of the components.
    pub frame: DistributedFrame,
    /// Force on every station per unit of the time function, N - (stations x 3); empty where there is none.
    pub force: Vec<f64>,
    /// Moment on every station per unit of the time function, N m - (stations x 3); empty where there is none.
    pub moment: Vec<f64>,
    /// Factor over time.
    pub time: crate::time::TimeFunction,
}

/// A named load case with the settings its author ran it with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadCase {
    /// Name, as used on the command line.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub name: String,
    /// One line for people.
    #[serde(deserialize_with = "crate::format::text::string")]
    pub description: String,
    /// End of the run, s.
    pub t_end: f64,
    /// Time step, s.
    pub dt: f64,
    /// Numerical damping `a` of the implicit integrators (Newmark: gamma = 1/2 + a).
    pub numerical_damping: f64,
    /// Loads, applied together.
    pub loads: Vec<Load>,
    /// Distributed loads, applied besides.
    pub distributed: Vec<DistributedLoad>,
    /// What moves frame A; none in free flight.
    pub motion: Option<BaseMotion>,
    /// Where the run starts; none at rest in the equilibrium.
    pub initial: Option<InitialState>,
}

impl LoadCase {
    /// Nothing but what acts anyway, the loads of the equilibrium and gravity: 1 s in one step.
    pub fn empty(name: &str) -> Self {
        Self {
            name: name.into(),
            description: String::new(),
            t_end: 1.0,
            dt: 1.0,
            numerical_damping: 0.0,
            loads: Vec::new(),
            distributed: Vec::new(),
            motion: None,
            initial: None,
        }
    }
}

impl InitialState {
    /// The loads of the static shape as a load case.
    pub fn shape_case(&self) -> LoadCase {
        LoadCase {
            loads: self.shape.clone(),
            distributed: self.shape_distributed.clone(),
            ..LoadCase::empty("initial shape")
        }
    }
}

/// Start of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InitialState {
    /// Attitude of A: unit quaternion, scalar first, components in A to components in G; none: that of the equilibrium.
    pub attitude: Option<[f64; 4]>,
    /// Position of the origin of A in G, m; none: where the drawing has it.
    pub position: Option<[f64; 3]>,
    /// Velocity of the origin of A, m/s - (3). None: at rest, or as the functions that move A have it; likewise below.
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity of A, rad/s - (3).
    pub angular_velocity: Option<[f64; 3]>,
    /// Whether the velocities are components in G; else in A.
    pub inertial: bool,
    /// Amplitudes of the elastic modes by their number in the ascending list, from 1; zero for those beyond.
    pub amplitudes: Vec<f64>,
    /// Their rates, 1/s.
    pub rates: Vec<f64>,
    /// Loads in balance with the elastic forces while A is held and at rest: the structure starts in the shape they give it, beyond
    /// that of the equilibrium. They are taken at t = 0 and do not act afterwards.
    pub shape: Vec<Load>,
    /// Distributed loads of the same.
    pub shape_distributed: Vec<DistributedLoad>,
}
