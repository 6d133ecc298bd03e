//! A model behind a UDP socket, for hosts in any language: `romrun --serve`, docs/udp.md.
//!
//! [`Server::answer`] is the whole protocol, without a socket: a packet in, a packet out or none. It allocates nothing.

pub mod latency;
pub mod packet;

use std::net::SocketAddr;
use std::sync::Arc;

use rom_runtime::loads::{LoadCase, LoadFrame};
use rom_runtime::{LoadSet, Method, Model, Settings, Simulation, State};
use serde::Serialize;

use packet::{ERROR, Kind, Malformed, REPLY, Request, WRENCH, Writer, floats_at, parse, u32_at};

/// States that a host can save.
pub const SLOTS: usize = 16;
/// Most steps of one request.
pub const MOST_STEPS: u32 = 1_000_000;
/// Most bytes of the words in an error and of a name.
const MOST_TEXT: usize = 400;

/// What to serve.
#[derive(Clone, Debug)]
pub struct Options {
    /// How it is marched.
    pub settings: Settings,
    /// Load case that acts besides the host's wrenches.
    pub case: Option<LoadCase>,
    /// Points that are loaded and told, by their index in the model.
    pub points: Vec<usize>,
    /// Whether to tell attitudes, velocities and accelerations of the points too.
    pub point_motion: bool,
}

/// What came in and what was done, for the summary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Packets that came in.
    pub received: u64,
    /// Requests done or refused with an error, each once.
    pub answered: u64,
    /// Replies sent again because the request came again.
    pub repeated: u64,
    /// Requests that were refused with an error; among those answered.
    pub refused: u64,
    /// Ignored: shorter or longer than they say.
    pub wrong_length: u64,
    /// Ignored: of another protocol.
    pub wrong_magic: u64,
    /// Ignored: of another version.
    pub wrong_version: u64,
    /// Ignored: damaged.
    pub wrong_checksum: u64,
    /// Ignored: not a request.
    pub wrong_kind: u64,
    /// Ignored: not of the session, or of another sender.
    pub strangers: u64,
    /// Ignored: older than the last one, or another one under its number.
    pub stale: u64,
    /// Time steps made.
    pub steps: u64,
}

impl Counts {
    /// Packets ignored, for whatever reason.
    pub fn ignored(&self) -> u64 {
        self.wrong_length
            + self.wrong_magic
            + self.wrong_version
            + self.wrong_checksum
            + self.wrong_kind
            + self.strangers
            + self.stale
    }
}

/// A host that said hello.
#[derive(Clone, Copy, Debug)]
struct Session {
    peer: SocketAddr,
    number: u32,
    sequence: u32,
    /// Of the last request.
    checksum: u32,
}

/// A simulation and what a host may ask of it.
pub struct Server {
    model: Arc<Model>,
    options: Options,
    simulation: Simulation,
    loads: LoadSet,
    /// The state at the start, and one on its way, in the flat form.
    start: Vec<f64>,
    flat: Vec<f64>,
    /// For states on their way in.
    scratch: State,
    slots: Vec<Slot>,
    steps: u64,
    /// No step yet: the accelerations are to be those under the loads of the first one.
    fresh: bool,
    session: Option<Session>,
    writer: Writer,
    /// What came and what was done.
    pub counts: Counts,
}

#[derive(Clone, Debug)]
struct Slot {
    flat: Vec<f64>,
    steps: u64,
    fresh: bool,
    used: bool,
}

impl Server {
    /// Where the load case starts, at rest without one, at t = 0.
    ///
    /// # Errors
    /// Settings, points or loads that do not fit the model; more outputs than a packet holds. In words.
    pub fn new(model: &Arc<Model>, options: Options) -> Result<Self, String> {
        let mut simulation =
            Simulation::new(Arc::clone(model), options.settings).map_err(|e| e.to_string())?;
        if let Some(case) = &options.case {
            let state = model.initial_state(case).map_err(|e| e.to_string())?;
            simulation.restore(&state).map_err(|e| e.to_string())?;
        }
        let loads = match &options.case {
            Some(case) => LoadSet::with_case(model, &options.points, case),
            None => LoadSet::new(model, &options.points),
        };
        let mut start = vec![0.0; model.flat_layout().size()];
        // The length is that of the model, here and below.
        let _ = simulation.state().write_flat(&mut start);
        let mut server = Self {
            model: Arc::clone(model),
            simulation,
            loads: loads.map_err(|e| e.to_string())?,
            scratch: State::at_rest(model),
            flat: start.clone(),
            slots: vec![Slot { flat: start.clone(), steps: 0, fresh: true, used: false }; SLOTS],
            start,
            steps: 0,
            fresh: true,
            session: None,
            writer: Writer::default(),
            counts: Counts::default(),
            options,
        };
        server.know()?;
        let bytes = packet::HEADER + packet::CHECKSUM + 8 + 8 * server.outputs();
        if bytes > packet::LARGEST {
            return Err(format!(
                "the outputs take {bytes} bytes, more than the {} of a datagram",
                packet::LARGEST
            ));
        }
        Ok(server)
    }

    /// Numbers in a state reply, after the number of steps.
    pub fn outputs(&self) -> usize {
        let per_point = if self.options.point_motion { 22 } else { 6 };
        32 + self.model.n_modes()
            + per_point * self.options.points.len()
            + 9 * self.model.data().sensors.len()
    }

    /// The reply to a packet; none for what is ignored.
    pub fn answer(&mut self, packet: &[u8], peer: SocketAddr) -> Option<&[u8]> {
        self.counts.received += 1;
        let request = match parse(packet) {
            Ok(request) => request,
            Err(problem) => {
                let counter = match problem {
                    Malformed::Length => &mut self.counts.wrong_length,
                    Malformed::Magic => &mut self.counts.wrong_magic,
                    Malformed::Version => &mut self.counts.wrong_version,
                    Malformed::Checksum => &mut self.counts.wrong_checksum,
                    Malformed::Kind => &mut self.counts.wrong_kind,
                };
                *counter += 1;
                return None;
            }
        };
        if self.is_new(&request, peer)? {
            self.counts.answered += 1;
            self.session = Some(Session {
                peer,
                number: request.session,
                sequence: request.sequence,
                checksum: request.checksum,
            });
            let (session, sequence) = (request.session, request.sequence);
            self.writer.begin(request.kind as u16 | REPLY, session, sequence);
            if let Err(message) = self.perform(&request) {
                self.counts.refused += 1;
                self.writer.begin(ERROR, session, sequence);
                self.writer.floats([&self.simulation.state().time]);
                self.writer.text(&message, MOST_TEXT);
            }
            Some(self.writer.finish())
        } else {
            self.counts.repeated += 1;
            Some(self.writer.last())
        }
    }

    /// Whether to do the request, or only to repeat the last reply; none to ignore it.
    fn is_new(&mut self, request: &Request, peer: SocketAddr) -> Option<bool> {
        let ours = self.session.filter(|known| known.peer == peer && known.number == request.session);
        let Some(known) = ours else {
            if request.kind == Kind::Hello {
                return Some(true);
            }
            self.counts.strangers += 1;
            return None;
        };
        // Numbers go round.
        let ahead = request.sequence.wrapping_sub(known.sequence);
        match ahead {
            0 if request.checksum == known.checksum => Some(false),
            1..=0x7fff_ffff => Some(true),
            _ => {
                self.counts.stale += 1;
                None
            }
        }
    }

    /// Does it and writes the reply.
    fn perform(&mut self, request: &Request) -> Result<(), String> {
        let payload = request.payload;
        match request.kind {
            Kind::Hello => {
                expect(payload, &[0])?;
                self.describe();
                return Ok(());
            }
            Kind::Name => return self.name(payload),
            Kind::Step => self.step(payload)?,
            Kind::Read => expect(payload, &[0])?,
            Kind::Reset => self.reset(payload)?,
            Kind::Snapshot => {
                let slot = slot(payload)?;
                let slot = &mut self.slots[slot];
                slot.used = self.simulation.state().write_flat(&mut slot.flat);
                (slot.steps, slot.fresh) = (self.steps, self.fresh);
            }
            Kind::Restore => self.restore(slot(payload)?)?,
        }
        self.know()?;
        self.write_state();
        Ok(())
    }

    fn describe(&mut self) {
        let data = self.model.data();
        self.writer.words(&[
            self.options.points.len() as u32,
            self.model.n_modes() as u32,
            data.sensors.len() as u32,
            u32::from(self.options.point_motion),
            self.outputs() as u32,
            SLOTS as u32,
        ]);
        self.writer.floats([&self.options.settings.dt]);
    }

    fn name(&mut self, payload: &[u8]) -> Result<(), String> {
        expect(payload, &[8])?;
        let (list, index) = (u32_at(payload, 0), u32_at(payload, 4).unwrap_or(u32::MAX) as usize);
        let data = self.model.data();
        let name = match list {
            Some(0) if index == 0 => Some(&data.provenance.name),
            Some(1) => self.options.points.get(index).and_then(|i| data.points.get(*i)).map(|p| &p.name),
            Some(2) => data.sensors.get(index).map(|sensor| &sensor.name),
            _ => None,
        };
        let name = name.ok_or("there is no such name: expected list 0 (model), 1 (points) or 2 (sensors)")?;
        self.writer.text(name, MOST_TEXT);
        Ok(())
    }

    fn step(&mut self, payload: &[u8]) -> Result<(), String> {
        let (Some(steps), Some(wrenches)) = (u32_at(payload, 0), u32_at(payload, 4)) else {
            return Err(format!("the payload has {} bytes, expected at least 8", payload.len()));
        };
        if !(1..=MOST_STEPS).contains(&steps) {
            return Err(format!("{steps} steps are asked for, expected 1 to {MOST_STEPS}"));
        }
        let (_, list) = payload.split_at(8);
        if list.len() as u64 != u64::from(wrenches) * WRENCH as u64 {
            return Err(format!("{} bytes for {wrenches} wrenches of {WRENCH}", list.len()));
        }
        self.loads.clear();
        for bytes in list.chunks_exact(WRENCH) {
            self.add(bytes)?;
        }
        if self.fresh {
            let _ = self.simulation.state().write_flat(&mut self.flat);
            let _ = self.scratch.read_flat(&self.flat);
            self.scratch.accelerations_known = false;
            self.simulation.restore(&self.scratch).map_err(|e| e.to_string())?;
            self.fresh = false;
        }
        for _ in 0..steps {
            self.simulation.step(&self.loads).map_err(|e| e.to_string())?;
            self.steps += 1;
            self.counts.steps += 1;
        }
        Ok(())
    }

    /// One wrench of the host.
    fn add(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (Some(point), Some(frame), Some(values)) =
            (u32_at(bytes, 0), u32_at(bytes, 4), floats_at::<6>(bytes, 8))
        else {
            return Err("a wrench is cut short".to_owned());
        };
        let count = self.options.points.len();
        let data = self.options.points.get(point as usize).and_then(|i| self.model.data().points.get(*i));
        let data = data.ok_or_else(|| format!("point {point} is loaded, expected less than {count}"))?;
        if let Some(found) = values.iter().find(|value| !value.is_finite()) {
            return Err(format!("the wrench on point {point} holds {found}, expected finite numbers"));
        }
        let frame = match frame {
            0 => LoadFrame::Dead,
            1 => LoadFrame::Body,
            member => {
                let section = data.sections.get(member as usize - 2).map(|(_, section)| *section);
                let sections = data.sections.len();
                LoadFrame::Follower {
                    section: section.ok_or_else(|| {
                        format!(
                            "frame {member} on point {point}, expected 0 (G), 1 (A) or 2 to {} (sections)",
                            1 + sections
                        )
                    })?,
                }
            }
        };
        let [fx, fy, fz, mx, my, mz] = values;
        // The slot is there: the index was looked up above.
        let _ = self.loads.add(point as usize, &frame, [fx, fy, fz], [mx, my, mz]);
        Ok(())
    }

    /// To the start, or to a given motion of A there: position, velocity, angular velocity, attitude.
    fn reset(&mut self, payload: &[u8]) -> Result<(), String> {
        expect(payload, &[0, 104])?;
        let _ = self.scratch.read_flat(&self.start);
        if let Some([rx, ry, rz, vx, vy, vz, wx, wy, wz, z0, z1, z2, z3]) = floats_at::<13>(payload, 0) {
            if self.model.method() == Method::MeanAxes {
                return Err(
                    "the state of a mean-axes model is not about A: reset it without a motion".to_owned()
                );
            }
            self.scratch.position = [rx, ry, rz];
            // The modes are at rest: the velocity of A is the rigid one.
            self.scratch.beta_star = [vx, vy, vz, wx, wy, wz];
            self.scratch.attitude = [z0, z1, z2, z3];
        }
        self.simulation.restore(&self.scratch).map_err(|e| e.to_string())?;
        (self.steps, self.fresh) = (0, true);
        self.loads.clear();
        Ok(())
    }

    fn restore(&mut self, index: usize) -> Result<(), String> {
        let slot = &self.slots[index];
        if !slot.used {
            return Err(format!("no state was saved in slot {index}"));
        }
        let _ = self.scratch.read_flat(&slot.flat);
        self.simulation.restore(&self.scratch).map_err(|e| e.to_string())?;
        (self.steps, self.fresh) = (slot.steps, slot.fresh);
        Ok(())
    }

    /// Accelerations are told under the loads of the last step.
    fn know(&mut self) -> Result<(), String> {
        if self.options.point_motion || !self.model.data().sensors.is_empty() {
            self.simulation.solve_accelerations(&self.loads).map_err(|e| e.to_string())?;
        }
        Ok(())
    }

    fn write_state(&mut self) {
        let (simulation, writer) = (&self.simulation, &mut self.writer);
        writer.bytes(&self.steps.to_le_bytes());
        let rigid = simulation.rigid_output();
        writer.floats([&simulation.state().time]);
        for vector in [rigid.r_g, rigid.v_g, rigid.w_g, rigid.v_a, rigid.w_a] {
            writer.floats(&vector);
        }
        writer.floats(&rigid.zeta);
        let ledger = simulation.ledger();
        for vector in [ledger.r_cm_g, ledger.linear_momentum_g, ledger.angular_momentum_g] {
            writer.floats(&vector);
        }
        writer.floats(&[ledger.kinetic_energy, ledger.elastic_energy, ledger.gravity_energy]);
        writer.floats(&simulation.state().q);
        for point in &self.options.points {
            // Every index was looked up when the server was made; accelerations are known.
            if let Some(out) = simulation.point_output(*point) {
                writer.floats(out.dr_a.iter().chain(&out.r_g));
            }
            if self.options.point_motion
                && let Some(motion) = simulation.point_motion(*point)
            {
                writer.floats(&motion.attitude);
                writer.floats([motion.v_g, motion.w_g, motion.a_g, motion.alpha_g].as_flattened());
            }
        }
        for sensor in 0..self.model.data().sensors.len() {
            if let Some(reading) = simulation.sensor_reading(sensor) {
                writer.floats([reading.a, reading.w, reading.alpha].as_flattened());
            }
        }
    }
}

fn expect(payload: &[u8], lengths: &[usize]) -> Result<(), String> {
    if lengths.contains(&payload.len()) {
        return Ok(());
    }
    Err(format!("the payload has {} bytes, expected {lengths:?}", payload.len()))
}

fn slot(payload: &[u8]) -> Result<usize, String> {
    expect(payload, &[4])?;
    let slot = u32_at(payload, 0).map_or(SLOTS, |slot| slot as usize);
    if slot < SLOTS { Ok(slot) } else { Err(format!("slot {slot} is named, expected less than {SLOTS}")) }
}
