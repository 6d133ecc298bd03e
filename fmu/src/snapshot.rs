//! The state of an instance, to go back to: a copy in memory, or bytes.
//!
//! All of it is there: an instance of the same model that is set to it, in this process or another with the same build, goes on
//! with the same bits.

use crate::instance::{Instance, Phase};
use crate::parameters::{Parameters, REALS};
use crate::token::{Token, checksum};

/// A state.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    phase: Phase,
    parameters: Parameters,
    start_time: f64,
    inputs: Vec<f64>,
    run: Option<RunState>,
}

#[derive(Clone, Debug, PartialEq)]
struct RunState {
    fresh: bool,
    odd_length: f64,
    /// Inputs of the last step; empty before the first.
    held: Vec<f64>,
    /// State of the simulation in its flat form.
    flat: Vec<f64>,
}

const MAGIC: [u8; 8] = *b"ROMFMU\0\x02";

impl Instance {
    /// The state now.
    pub fn snapshot(&self) -> Snapshot {
        let run = self.run.as_ref().map(|run| {
            let state = run.simulation.state();
            let mut flat = vec![0.0; state.flat_layout().size()];
            // The length is right.
            let _ = state.write_flat(&mut flat);
            RunState { fresh: run.fresh, odd_length: run.odd_length(), held: run.held.clone(), flat }
        });
        Snapshot {
            phase: self.phase,
            parameters: self.parameters,
            start_time: self.start_time,
            inputs: self.inputs.clone(),
            run,
        }
    }

    /// Goes back, or on, to a state.
    ///
    /// # Errors
    /// A state of another model. The instance stays as it is then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        if snapshot.inputs.len() != self.inputs.len() {
            return Err(format!(
                "the state has {} inputs, expected {}",
                snapshot.inputs.len(),
                self.inputs.len()
            ));
        }
        let mut before = (self.phase, self.parameters, self.start_time, None);
        if self.parameters != snapshot.parameters || snapshot.run.is_none() {
            before.3 = self.run.take();
        }
        (self.phase, self.parameters, self.start_time) =
            (snapshot.phase, snapshot.parameters, snapshot.start_time);
        if let Some(wanted) = &snapshot.run
            && let Err(message) = self.take_over(wanted)
        {
            (self.phase, self.parameters, self.start_time) = (before.0, before.1, before.2);
            self.run = before.3.or(self.run.take());
            return Err(message);
        }
        self.inputs.copy_from_slice(&snapshot.inputs);
        Ok(())
    }

    fn take_over(&mut self, wanted: &RunState) -> Result<(), String> {
        let run = self.run()?;
        let mut state = run.simulation.state().clone();
        if !state.read_flat(&wanted.flat) {
            return Err("the state is that of a model with another number of modes".to_owned());
        }
        run.simulation.restore(&state).map_err(|e| e.to_string())?;
        run.set_odd_length(wanted.odd_length)?;
        run.fresh = wanted.fresh;
        run.held.clone_from(&wanted.held);
        run.changed();
        Ok(())
    }
}

impl Snapshot {
    /// As bytes, for the model with this token: little-endian, with a checksum.
    pub fn to_bytes(&self, token: Token) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend(token.0.to_le_bytes());
        let mut parameters = self.parameters;
        let (phase, p) = (self.phase as u8, &self.parameters);
        out.extend([phase, u8::from(p.equilibrium_loads)]);
        for choice in [p.load_case, p.method, p.integrator] {
            out.extend(choice.to_le_bytes());
        }
        for place in 0..REALS {
            out.extend(parameters.real(place).map_or(0.0, |x| *x).to_le_bytes());
        }
        let mut floats = |values: &[f64]| {
            out.extend((values.len() as u64).to_le_bytes());
            values.iter().for_each(|value| out.extend(value.to_le_bytes()));
        };
        floats(&[self.start_time]);
        floats(&self.inputs);
        match &self.run {
            None => floats(&[]),
            Some(run) => {
                floats(&[f64::from(u8::from(run.fresh)), run.odd_length]);
                floats(&run.held);
                floats(&run.flat);
            }
        }
        let sum = checksum(&out);
        out.extend(sum.to_le_bytes());
        out
    }

    /// From bytes.
    ///
    /// # Errors
    /// Bytes that are no state of the model with this token.
    pub fn from_bytes(bytes: &[u8], token: Token) -> Result<Self, String> {
        let damaged = || "the serialised state is damaged or of another kind".to_owned();
        let (body, sum) = bytes.split_last_chunk::<8>().ok_or_else(damaged)?;
        if checksum(body) != u64::from_le_bytes(*sum) || !body.starts_with(&MAGIC) {
            return Err(damaged());
        }
        Self::read(&mut Reader(&body[MAGIC.len()..]), token).ok_or_else(|| {
            "the serialised state is not of this FMU: it belongs to another model or version".to_owned()
        })
    }

    fn read(from: &mut Reader, token: Token) -> Option<Self> {
        if u128::from_le_bytes(from.take()?) != token.0 {
            return None;
        }
        let [phase, equilibrium_loads] = from.take()?;
        let phase = [Phase::Instantiated, Phase::Initialization, Phase::Step, Phase::Terminated]
            .into_iter()
            .find(|known| *known as u8 == phase)?;
        let mut parameters = Parameters {
            load_case: i64::from_le_bytes(from.take()?),
            method: i64::from_le_bytes(from.take()?),
            integrator: i64::from_le_bytes(from.take()?),
            dt: 0.0,
            numerical_damping: 0.0,
            equilibrium_loads: equilibrium_loads != 0,
            gravity: [0.0; 3],
            initial: crate::parameters::Initial {
                r_g: [0.0; 3],
                v_a: [0.0; 3],
                w_a: [0.0; 3],
                zeta: [0.0; 4],
            },
        };
        for place in 0..REALS {
            *parameters.real(place)? = f64::from_le_bytes(from.take()?);
        }
        let [start_time] = from.floats()?[..] else { return None };
        let inputs = from.floats()?;
        let run = match from.floats()?[..] {
            [] => None,
            [fresh, odd_length] => {
                let (held, flat) = (from.floats()?, from.floats()?);
                Some(RunState { fresh: fresh != 0.0, odd_length, held, flat })
            }
            _ => return None,
        };
        from.0.is_empty().then_some(Snapshot { phase, parameters, start_time, inputs, run })
    }
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*head)
    }

    fn floats(&mut self) -> Option<Vec<f64>> {
        let n = usize::try_from(u64::from_le_bytes(self.take()?)).ok()?;
        if n > self.0.len() / 8 {
            return None;
        }
        (0..n).map(|_| self.take().map(f64::from_le_bytes)).collect()
    }
}
