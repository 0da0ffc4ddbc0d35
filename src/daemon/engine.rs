//! The engine thread: one stream's pipeline, driven by events.
//!
//! In: inputs, ticks and signals, one closed set of [`Event`]s. Out: [`FrameLine`]s to the writer. Invariants: a frame is computed when
//! it is closed, since its line is due then; every frame starts from the one before; what is refused is counted in the frame that it was
//! meant for. Must not know: parsing, formats' bytes.

use std::time::Instant;

use crossbeam_channel::{Receiver, Sender, select};
use hopes::topology::{Follower, Pipeline, Refusal};

use super::complaints::Complaints;
use super::frame_line::FrameLine;
use super::{DaemonError, Input, Point, Settings};

enum Event {
    Input(Input),
    InputEnded,
    Tick,
    Signal(&'static str),
}

/// A stream at work.
pub struct Engine {
    settings: Settings,
    pipeline: Pipeline,
    lines: Sender<FrameLine>,
    complaints: Complaints,
    /// Knows what consumers have by now.
    follower: Follower,
    frames: u64,
    /// Complaints that former frames have told of.
    told: u64,
    /// Points taken since the last frame.
    points: u64,
    /// Whether anything came since the last frame.
    pending: bool,
    newest_time: Option<f64>,
}

/// Whether to go on.
enum Next {
    GoOn,
    Stop,
}

impl Engine {
    pub fn new(settings: Settings, lines: Sender<FrameLine>) -> Self {
        Self {
            pipeline: Pipeline::new(settings.options),
            complaints: Complaints::new(settings.strict),
            follower: Follower::new(settings.view),
            settings,
            lines,
            frames: 0,
            told: 0,
            points: 0,
            pending: false,
            newest_time: None,
        }
    }

    /// Works until the input ends, a signal comes, or the writer is gone.
    pub fn run(
        mut self,
        inputs: &Receiver<Input>,
        ticks: &Receiver<Instant>,
        signals: &Receiver<&'static str>,
    ) -> Result<(), DaemonError> {
        loop {
            let event = select! {
                recv(inputs) -> input => input.map_or(Event::InputEnded, Event::Input),
                recv(ticks) -> _ => Event::Tick,
                recv(signals) -> signal => Event::Signal(signal.unwrap_or("signal")),
            };
            if let Next::Stop = self.handle(event)? {
                self.complaints.sum_up();
                tracing::debug!("{} frames, {} rejected", self.frames, self.complaints.count());
                return Ok(());
            }
        }
    }

    fn handle(&mut self, event: Event) -> Result<Next, DaemonError> {
        match event {
            Event::Input(input) => self.take(input),
            Event::Tick => self.close_frame(None),
            Event::InputEnded => {
                if self.pending || self.frames == 0 {
                    self.close_frame(None)?;
                }
                Ok(Next::Stop)
            }
            Event::Signal(name) => {
                if self.pending {
                    self.close_frame(None)?;
                }
                tracing::info!("{name}: stopped after frame {}", self.frames);
                Ok(Next::Stop)
            }
        }
    }

    fn take(&mut self, input: Input) -> Result<Next, DaemonError> {
        match input {
            Input::Commit(time) => {
                if let Some(Err(refusal)) = time.map(|time| self.pipeline.feed_time(time)) {
                    self.complaints.add(&refusal)?;
                }
                return self.close_frame(time);
            }
            Input::Points(points) => {
                for point in points {
                    if let Next::Stop = self.insert(point)? {
                        return Ok(Next::Stop);
                    }
                }
            }
            Input::Retract(points) => {
                self.pending = true;
                for point in points {
                    let [x, y] = point.position;
                    let answer = self.pipeline.feed_retraction(x, y);
                    self.complain(point, answer)?;
                }
            }
            Input::Unreadable(complaint) => {
                self.pending = true;
                self.complaints.add(&complaint)?;
            }
            Input::Failed(reason) => return Err(DaemonError::Source(reason)),
        }
        Ok(Next::GoOn)
    }

    fn insert(&mut self, point: Point) -> Result<Next, DaemonError> {
        self.pending = true;
        let [x, y] = point.position;
        let answer = self.pipeline.feed_point(x, y, point.time);
        if answer.is_ok() {
            self.points += 1;
            self.newest_time = point.time.into_iter().chain(self.newest_time).reduce(f64::max);
        }
        self.complain(point, answer)?;
        match self.settings.frame_points {
            Some(limit) if self.points >= limit => self.close_frame(None),
            _ => Ok(Next::GoOn),
        }
    }

    fn complain(&mut self, point: Point, answer: Result<(), Refusal>) -> Result<(), DaemonError> {
        if let Err(refusal) = answer {
            let ([x, y], line) = (point.position, point.line);
            self.complaints.add(&format_args!("line {line}, point ({x}, {y}): {refusal}"))?;
        }
        Ok(())
    }

    /// Closes the frame in hand and sends its line; waits while the writer is behind.
    fn close_frame(&mut self, time: Option<f64>) -> Result<Next, DaemonError> {
        self.pipeline.commit(time.or(self.newest_time));
        let Some(step) = self.pipeline.poll_step(&mut self.follower) else { return Ok(Next::GoOn) };
        if self.settings.check {
            self.pipeline.check(&self.follower)?;
        }
        let rejected = self.complaints.count() - self.told;
        self.frames = step.number;
        self.told += rejected;
        self.points = 0;
        self.pending = false;
        let line = FrameLine::new(&step, rejected);
        Ok(if self.lines.send(line).is_ok() { Next::GoOn } else { Next::Stop })
    }
}
