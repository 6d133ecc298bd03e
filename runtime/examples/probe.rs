#[path = "../tests/common/mod.rs"]
mod common;
use rom_runtime::*;
use std::sync::Arc;
use rom_runtime::time::TimeFunction;
fn best(mut f: impl FnMut()) -> f64 { let mut b=f64::MAX; for _ in 0..400 { let t=std::time::Instant::now(); for _ in 0..500 { f(); } b=b.min(t.elapsed().as_secs_f64()/500.0);} b*1e9 }
fn main() {
    for m in [0,10,40] {
        let model = Arc::new(Model::new(common::Lumped::frame(m).data(1)).unwrap());
        println!("m={m} fill {:?} omega {:?} stable {:?}", model.tensor_fill(), model.data().modes.omega.last(), Integrator::Rk4.stable_dt(&model));
        let r=(model.n_points()-1) as u32;
        let mk=|frame:LoadFrame| { let l=|p:u32,f:[f64;3]| Load{point:p,frame:frame.clone(),force:f,moment:[0.0;3],time:TimeFunction::Ramp{rate:10.0,start:0.0,end:10.0}};
          model.prepare(&LoadCase{name:"x".into(),description:"".into(),t_end:1.0,dt:0.01,numerical_damping:0.0,loads:vec![l(r,[0.,0.,1.]),l(0,[0.,0.,-1.]),l(r-20,[0.,0.1,0.]),l(20,[0.,-0.1,0.])]}).unwrap() };
        let dead=mk(LoadFrame::Dead); let fol=mk(LoadFrame::Follower{section:[[1.,0.,0.],[0.,1.,0.],[0.,0.,1.]]});
        let mut sim=Simulation::new(model.clone(),Settings{dt:1e-3,..Default::default()}).unwrap();
        for _ in 0..5000 { sim.step(&dead).unwrap(); }
        let st=sim.state().clone();
        println!("beta {:?} q {:?}", model.velocity(&st), st.q.iter().fold(0.0f64,|a,b|a.max(b.abs())));
        let (mut w,mut rt)=(Workspace::new(&model),StateRate::new(&model));
        println!("eval none {:.0} dead {:.0} follower {:.0}", best(||model.derivatives(&st,&model_none(&model),&mut w,&mut rt).unwrap()), best(||model.derivatives(&st,&dead,&mut w,&mut rt).unwrap()),best(||model.derivatives(&st,&fol,&mut w,&mut rt).unwrap()));
        let none=model.no_loads();
        println!("eval none {:.0}", best(||model.derivatives(&st,&none,&mut w,&mut rt).unwrap()));
        for (i,dt) in [(Integrator::Newmark,0.01),(Integrator::Newmark,0.001),(Integrator::GeneralizedAlpha,0.01),(Integrator::Rk4,1e-9)] {
            let mut sim=Simulation::new(model.clone(),Settings{dt,integrator:i,..Default::default()}).unwrap();
            let mut k=0;
            let t=best(|| { if k%200==0 { sim.restore(&st).unwrap(); } k+=1; sim.step(&dead).unwrap(); });
            println!("{i} {dt} {t:.0} ns");
        }
    }
}
fn model_none(m:&Model)->PreparedLoads{m.no_loads()}
