//! wip
use std::time::Instant;
use hopes::topology::*;
use hopes::topology::{delaunay::Delaunay,cloud::Cloud,filtration::Filtration,basins::Basins};
fn main(){
    let f=std::env::args().nth(1).unwrap();
    let b=std::fs::read(&f).unwrap();
    let pts:Vec<[f64;2]>=b.chunks_exact(16).map(|c|[f64::from_le_bytes(c[..8].try_into().unwrap()),f64::from_le_bytes(c[8..].try_into().unwrap())]).collect();
    for _ in 0..3 {
        let t=Instant::now();
        let mut p=Pipeline::new(Options::default());
        p.feed_points(&pts,None); p.commit(None);
        let t1=t.elapsed();
        let fr=p.poll_frame().unwrap();
        let t2=t.elapsed();
        let v=fr.view(ViewSpec::default());
        let t3=t.elapsed();
        println!("n {} dots {} mst {} cycles {} | feed {:?} frame {:?} view {:?} total {:?}",fr.skeleton.vertices().len(),fr.skeleton.dots().len(),fr.skeleton.tree_length(),v.cycles,t1,t2-t1,t3-t2,t3);
        drop(p); drop(fr);
        let mut c=Cloud::new(Window::All,None); c.reserve(pts.len()); for q in &pts {c.insert(q[0],q[1],None).unwrap();}
        let mut t=Instant::now(); let ch=c.commit();
        let mut lap=|s:&str|{print!("{s} {:.1} ",t.elapsed().as_secs_f64()*1e3); t=Instant::now();};
        lap("commit");
        let mut d=Delaunay::default(); d.apply(&c,&ch); lap("delaunay");
        let m=d.mesh(); lap("mesh");
        let fi=Filtration::new(&m); lap("filtration");
        let ba=Basins::new(&m,&fi); lap("basins");
        let mut rank=vec![0;c.slot_count()]; let mut vs=vec![]; for (s,v) in c.vertices(){rank[s as usize]=vs.len() as u32; vs.push(v);} lap("rank");
        let s=Skeleton::new(vs,&rank,&m); lap("skeleton(all)"); println!("suspects {} basins {}",fi.suspects().len(), ba.all().len()); drop(s);
    }
}
