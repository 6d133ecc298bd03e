// The flexible aircraft of docs/rust.md, as it stands there; a test runs it.

use rom_runtime::{LoadCase, LoadFrame, LoadSet, Model, Settings, Simulation};
use std::sync::Arc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Arc::new(Model::read_path("hale.rom")?);
    let (tail, tip) = (model.point("fin top")?, model.point("left tip")?);
    let mut loads = LoadSet::with_case(&model, &[tail], &LoadCase::empty("equilibrium"))?;
    let mut simulation = Simulation::new(model.clone(), Settings { dt: 0.01, ..Settings::default() })?;
    for _ in 0..1000 {
        let pitch_rate = simulation.rigid_output().w_a[1]; // known before the loads are set
        loads.clear();
        if !loads.add(0, &LoadFrame::Body, [0.0, 0.0, 200.0 * pitch_rate], [0.0; 3]) {
            return Err("the set was made for one point".into());
        }
        simulation.step(&loads)?;
    }
    if let Some(tip) = simulation.point_output(tip) {
        println!("the tip has moved by {:?} m in the axes of the aircraft", tip.dr_a);
    }
    Ok(())
}
