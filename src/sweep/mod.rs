//! Many cases of one model: which, marched side by side on all cores, and what came out of each as a line on disk.

mod log;
mod variables;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use npyz::npz::NpzWriter;
use rom_runtime::{Batch, Integrator, LoadCase, Model, PreparedLoads, Settings, State};
use serde_json::json;

use crate::run::{Extreme, Peaks, TimeGrid};
use crate::text::{columns, significant};
use crate::{atomic, interrupt, parallel, results};
pub use variables::{Variable, change_start, table, values};

/// A case: loads, instants, and how it starts.
#[derive(Clone, Debug)]
pub struct Case {
    /// Loads, with the variables in them.
    pub case: LoadCase,
    /// Instants.
    pub grid: TimeGrid,
    /// Of the integrator.
    pub numerical_damping: f64,
    /// What differs from case to case.
    pub values: Vec<(Variable, f64)>,
    /// Place of its load case among those asked for.
    pub load_case: usize,
}

/// All cases of a sweep.
#[derive(Debug)]
pub struct Sweep {
    /// The model.
    pub model: Arc<Model>,
    /// Names of the variables, as given.
    pub names: Vec<String>,
    /// Names of the load cases.
    pub load_cases: Vec<String>,
    /// In the order of their numbers.
    pub cases: Vec<Case>,
    /// For all of them.
    pub integrator: Integrator,
    /// Indices of the points to look at.
    pub points: Vec<usize>,
    /// What the run is called by, besides what is in the cases: the bytes of the model, in short.
    pub identity: String,
}

/// What came out.
#[derive(Debug)]
pub struct Done {
    /// Cases in all, and those found from an earlier run.
    pub cases: (usize, usize),
    /// Those whose numbers failed.
    pub failed: Vec<usize>,
    /// Largest values over the cases.
    pub summary: String,
    /// The table.
    pub csv: PathBuf,
    /// The same as arrays.
    pub npz: PathBuf,
}

/// Cases that go through the lanes of a batch together.
const TOGETHER: usize = 8;

impl Sweep {
    /// Runs what is not done yet, and stops after the cases in work when it is interrupted; `progress` is told the number of cases done so far.
    ///
    /// # Errors
    /// Those of the file system, `InvalidInput` when the folder holds another sweep.
    pub fn run(&self, folder: &Path, progress: impl Fn(u64) + Sync) -> io::Result<Done> {
        let names = self.columns();
        let head = format!("case,{}", names.join(","));
        let identity = serde_json::to_string_pretty(&self.identity())?;
        let (log, earlier) = log::Log::open(folder, &identity, &head, names.len())?;
        let mut rows: BTreeMap<usize, Vec<f64>> =
            earlier.done.into_iter().filter(|(case, _)| *case < self.cases.len()).collect();
        let found = rows.len();
        let left: Vec<usize> = (0..self.cases.len()).filter(|case| !rows.contains_key(case)).collect();
        let count = Mutex::new(found as u64);
        let written = parallel::map(&self.chunks(&left), |chunk| -> io::Result<Vec<(usize, Vec<f64>)>> {
            if interrupt::requested() {
                return Ok(Vec::new());
            }
            let lines = self.march(chunk)?;
            let text: String = lines.iter().map(|(case, values)| log::line(*case, values)).collect();
            log.append(&text)?;
            let mut count = count.lock().unwrap_or_else(PoisonError::into_inner);
            *count += lines.len() as u64;
            progress(*count);
            Ok(lines)
        });
        for lines in written {
            rows.extend(lines?);
        }
        let rows: Vec<(usize, Vec<f64>)> = rows.into_iter().collect();
        let (csv, npz) = (folder.join("cases.csv"), folder.join("cases.npz"));
        log::write_table(&csv, &head, &rows)?;
        self.write_npz(&npz, &names, &rows)?;
        let completed = names.iter().position(|name| name == "completed").unwrap_or(0);
        let failed = rows.iter().filter(|(_, row)| row[completed] == 0.0).map(|(case, _)| *case).collect();
        Ok(Done { cases: (rows.len(), found), failed, summary: self.summary(&names, &rows), csv, npz })
    }

    /// Columns after the number of the case.
    fn columns(&self) -> Vec<String> {
        let mut names = vec!["load_case".to_owned()];
        names.extend(self.names.iter().cloned());
        names.extend(["completed", "t_last"].map(str::to_owned));
        for vector in self.vectors() {
            names.extend(["peak", "t_peak", "x", "y", "z"].map(|what| format!("{vector}.{what}")));
        }
        names
    }

    fn vectors(&self) -> Vec<String> {
        let points = self.points.iter().map(|&i| format!("{}.dR_A", self.model.data().points[i].name));
        ["v_G", "w_G"].map(str::to_owned).into_iter().chain(points).collect()
    }

    /// What makes two sweeps the same.
    fn identity(&self) -> serde_json::Value {
        let cases: Vec<_> = self
            .cases
            .iter()
            .map(|case| {
                let values: Vec<f64> = case.values.iter().map(|(_, value)| *value).collect();
                (&case.case, case.grid.dt, case.grid.steps, case.numerical_damping, values)
            })
            .collect();
        // In short: the cases themselves may be many.
        let bytes = serde_json::to_vec(&cases).unwrap_or_default();
        json!({
            "model": self.identity,
            "method": self.model.method().name(),
            "integrator": self.integrator.name(),
            "load_cases": self.load_cases,
            "variables": self.names,
            "cases": self.cases.len(),
            "points": self.points,
            "crc32": crc32fast::hash(&bytes),
        })
    }

    /// Cases that can be marched together: of the same step, end and numerical damping.
    fn chunks(&self, left: &[usize]) -> Vec<Vec<usize>> {
        let mut chunks: Vec<Vec<usize>> = Vec::new();
        let alike = |a: usize, b: usize| {
            let (a, b) = (&self.cases[a], &self.cases[b]);
            a.grid == b.grid && a.numerical_damping == b.numerical_damping && a.load_case == b.load_case
        };
        for &case in left {
            match chunks.last_mut() {
                Some(chunk) if chunk.len() < TOGETHER && alike(chunk[0], case) => chunk.push(case),
                _ => chunks.push(vec![case]),
            }
        }
        chunks
    }

    /// Marches cases side by side: number and line of each.
    fn march(&self, chunk: &[usize]) -> io::Result<Vec<(usize, Vec<f64>)>> {
        let first = &self.cases[chunk[0]];
        // Every field by name: what is new in a load case has to act here too.
        let LoadCase {
            name: _,
            description: _,
            t_end: _,
            dt: _,
            numerical_damping: _,
            loads: _,
            motion: _,
            initial: _,
            distributed: _,
        } = &first.case;
        let settings = Settings {
            dt: first.grid.dt,
            integrator: self.integrator,
            numerical_damping: first.numerical_damping,
            ..Settings::default()
        };
        let model = &self.model;
        let mut batch = Batch::new(model.clone(), settings, chunk.len()).map_err(io::Error::other)?;
        let mut loads: Vec<PreparedLoads> = Vec::new();
        let mut state = State::at_rest(model);
        let mut watch: Vec<Vec<Peaks>> = Vec::new();
        for (lane, &case) in chunk.iter().enumerate() {
            loads.push(model.prepare(&self.cases[case].case).map_err(io::Error::other)?);
            let mut start = model.initial_state(&self.cases[case].case).map_err(io::Error::other)?;
            change_start(model, &self.cases[case].values, &mut start);
            batch.restore(lane, &start).map_err(io::Error::other)?;
            watch.push(self.vectors().iter().map(|_| Peaks::new(3)).collect());
        }
        let mut last = vec![0_u64; chunk.len()];
        for step in 0..=first.grid.steps {
            if step > 0 && batch.step(&loads).map_err(io::Error::other)? == 0 {
                break;
            }
            for (lane, watch) in watch.iter_mut().enumerate() {
                if batch.error(lane).is_none() && batch.copy_state(lane, &mut state) {
                    self.see(&state, first.grid.time(step), watch);
                    last[lane] = step;
                }
            }
        }
        let line =
            |(lane, &case): (usize, &usize)| (case, self.line(&self.cases[case], last[lane], &watch[lane]));
        Ok(chunk.iter().enumerate().map(line).collect())
    }

    fn see(&self, state: &State, time: f64, watch: &mut [Peaks]) {
        let rigid = self.model.rigid_output(state);
        let points =
            self.points.iter().filter_map(|&point| Some(self.model.point_output(state, point)?.dr_a));
        for (peaks, vector) in watch.iter_mut().zip([rigid.v_g, rigid.w_g].into_iter().chain(points)) {
            peaks.see(time, &vector);
        }
    }

    fn line(&self, case: &Case, last: u64, watch: &[Peaks]) -> Vec<f64> {
        let mut line = vec![case.load_case as f64];
        line.extend(case.values.iter().map(|(_, value)| *value));
        line.push(f64::from(u8::from(last == case.grid.steps)));
        line.push(case.grid.time(last));
        for peaks in watch {
            line.extend([peaks.length.0, peaks.length.1]);
            line.extend(peaks.components.iter().map(|extreme| Extreme::farthest(extreme).0));
        }
        line
    }

    fn write_npz(&self, path: &Path, names: &[String], rows: &[(usize, Vec<f64>)]) -> io::Result<()> {
        atomic::write(path, |sink| {
            let mut archive = NpzWriter::new(sink);
            let shape = [rows.len() as u64];
            let numbers: Vec<f64> = rows.iter().map(|(case, _)| *case as f64).collect();
            results::write_array(&mut archive, "case", &shape, &numbers)?;
            for (column, name) in names.iter().enumerate() {
                let values: Vec<f64> = rows.iter().map(|(_, row)| row[column]).collect();
                results::write_array(&mut archive, name, &shape, &values)?;
            }
            let text =
                serde_json::to_vec(&json!({ "load_cases": self.load_cases, "variables": self.names }))?;
            results::write_array(&mut archive, "metadata", &[text.len() as u64], &text)?;
            archive.zip_writer().finish()?;
            Ok(())
        })
    }

    /// The largest of every quantity, and the case it is from.
    fn summary(&self, names: &[String], rows: &[(usize, Vec<f64>)]) -> String {
        let mut table = vec![["quantity", "largest", "at t (s)", "case", "where"].map(String::from).to_vec()];
        for (column, name) in names.iter().enumerate().filter(|(_, name)| name.ends_with(".peak")) {
            let largest = rows.iter().max_by(|a, b| a.1[column].total_cmp(&b.1[column]));
            let Some((case, row)) = largest else { continue };
            let mut place = vec![self.load_cases[row[0] as usize].clone()];
            place.extend(self.names.iter().zip(&row[1..]).map(|(name, value)| format!("{name}={value}")));
            table.push(vec![
                format!("|{}|", name.trim_end_matches(".peak")),
                significant(row[column], 5),
                significant(row[column + 1], 5),
                case.to_string(),
                place.join(", "),
            ]);
        }
        columns(&table)
    }
}
