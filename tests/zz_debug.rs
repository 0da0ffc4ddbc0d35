//! x
use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene};
use hopes::topology::{SpaceOptions as Stream, SpacePipeline, SpaceTracker, TrackOptions, TrackRule, Window};
#[test]
fn x() {
    let mut scene = SpaceScene::new(
        SpaceKind::Torus,
        SpaceOptions { points: 500, noise: 0.1, seed: 2, churn: 0.05, ..SpaceOptions::default() },
    )
    .unwrap();
    let above = scene.above().unwrap();
    println!("above {above}");
    let mut pipeline = SpacePipeline::new(Stream { window: Window::All, ..Stream::default() }).unwrap();
    let mut tracker = SpaceTracker::new(TrackOptions::new(TrackRule::Above(above)));
    for _ in 0..170 {
        let frame = scene.next_frame();
        frame.gone.iter().for_each(|point| pipeline.feed_retraction(point).unwrap());
        assert_eq!(pipeline.feed_points(&frame.come, None), []);
        pipeline.commit(None);
        let step = pipeline.poll_tracks(&mut tracker).unwrap();
        print!("{} gone {} ", frame.number, frame.gone.len());
        for t in &step.alive {
            let c = t.center.iter().zip(&frame.holes[0].center).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            print!(
                " | {} b {:.3} d {:.3} r {:.2} off {:.2} n {}",
                t.id.0,
                t.birth,
                t.death,
                t.radius,
                c,
                pipeline.track_cycles(&tracker).iter().find(|x| x.0 == t.id).map_or(0, |x| x.1.len())
            );
        }
        let dots = pipeline.poll_dots(4).dots;
        println!(
            "   {:?}",
            dots.iter().map(|d| format!("{:.2}-{:.2}", d.critical.birth, d.critical.death)).collect::<Vec<_>>()
        );
    }
}
