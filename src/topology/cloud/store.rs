//! The cloud: which positions are there now, and what changed since somebody last asked.
//!
//! In: points one by one (to insert or to retract), event times, commits. Out: vertices (distinct positions with an id) as of the
//! last commit and, when taken, a [`CloudChange`] that sums up all commits since the one taken before. Invariants: equal positions
//! share one vertex, which lives until the last of its points is gone; lives are judged at commits, so a vertex whose
//! position is left and taken again between two commits never left; ids rise in order of first appearance and are never
//! given twice; a slot is not reused before the change after the one that emptied it is taken. Must not know: triangulations, frames'
//! contents.

use std::collections::BTreeMap;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;

use super::position::Position;
use super::refusal::Refusal;
use super::vertex::{CloudChange, Slot, Vertex, VertexId};
use super::window::{Queue, Window};

#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) vertex: Vertex,
    /// Points on this position.
    points: u64,
    /// Points that were retracted while the window still holds their arrivals.
    pub(super) retracted: u32,
    life: Life,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Life {
    /// Appeared since the last commit.
    New,
    /// There at the last commit, but not yet told of in a change.
    Fresh,
    /// There at the last commit, and told of.
    Old,
    /// Not in use.
    Free,
}

/// The points of a stream, as distinct positions.
#[derive(Clone, Debug)]
pub struct Cloud {
    pub(super) window: Window,
    resolution: Option<f64>,
    pub(super) places: Vec<Place>,
    free: Vec<Slot>,
    by_position: HashTable<Slot>,
    pub(super) queue: Queue,
    /// Slots whose vertex may have appeared or vanished since the last commit; some stand in it twice.
    touched: Vec<Slot>,
    /// Slots that commits have made fresh; some no more, some twice.
    fresh: Vec<Slot>,
    /// Slots emptied by commits since the last change was taken.
    vanished: Vec<Slot>,
    /// Slots emptied in the last change taken.
    emptied: Vec<Slot>,
    /// Slots in order of id, vanished ones too until a sweep. None while no slot was reused: they are in that order then.
    order: Option<Vec<(VertexId, Slot)>>,
    /// Vertices in use, those of the frame in hand among them.
    used: usize,
    /// Vertices as of the last commit.
    committed: usize,
    pub(super) points: u64,
    next_id: u64,
    pub(super) newest_time: Option<f64>,
    pub(super) frame: u64,
}

impl Cloud {
    /// An empty cloud; `resolution` snaps positions to a grid of that step.
    pub fn new(window: Window, resolution: Option<f64>) -> Self {
        Self {
            window,
            resolution,
            places: Vec::new(),
            free: Vec::new(),
            by_position: HashTable::new(),
            queue: Queue::new(window),
            touched: Vec::new(),
            fresh: Vec::new(),
            vanished: Vec::new(),
            emptied: Vec::new(),
            order: None,
            used: 0,
            committed: 0,
            points: 0,
            next_id: 0,
            newest_time: None,
            frame: 1,
        }
    }

    /// Makes room for so many more points at once.
    pub fn reserve(&mut self, points: usize) {
        self.places.reserve(points.saturating_sub(self.free.len()));
        self.touched.reserve(points);
        let places = &self.places;
        self.by_position.reserve(points, |&slot| hash(places[slot as usize].vertex.position));
    }

    /// Adds a point; `time` is its event time. In a time window, a point without one counts as of the newest time known.
    ///
    /// # Errors
    /// [`Refusal`]; the cloud is then as it was.
    pub fn insert(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<Slot, Refusal> {
        let position = self.place_of(x, y)?;
        let key = self.key(time)?;
        let slot = self.occupy(position)?;
        self.points += 1;
        let vertex = self.places[slot as usize].vertex.id;
        if self.places[slot as usize].retracted > 0 && self.is_late(key) {
            // Retracted points are told by leaving first: a late one must not slip in before them.
            self.drop_retracted();
        }
        self.queue.push(key, slot, vertex);
        self.expire();
        Ok(slot)
    }

    /// Takes back the oldest point at a position.
    ///
    /// # Errors
    /// [`Refusal`]; the cloud is then as it was.
    pub fn retract(&mut self, x: f64, y: f64) -> Result<Slot, Refusal> {
        let position = self.place_of(x, y)?;
        let slot = self.find(position).ok_or(Refusal::NotThere { x, y })?;
        self.places[slot as usize].retracted += u32::from(self.window != Window::All);
        self.leave(slot);
        self.sweep_queue();
        Ok(slot)
    }

    /// Closes the frame.
    pub fn commit(&mut self) {
        if let Window::Frames(frames) = self.window {
            self.expire_below((self.frame + 1).saturating_sub(frames.get()) as f64);
        }
        self.frame += 1;
        let mut touched = std::mem::take(&mut self.touched);
        for &slot in &touched {
            self.settle(slot);
        }
        touched.clear();
        self.touched = touched;
        self.sweep_order();
        sweep(&mut self.fresh, self.places.len());
    }

    /// Judges a vertex' life at a commit.
    fn settle(&mut self, slot: Slot) {
        let place = &mut self.places[slot as usize];
        match (place.points > 0, place.life) {
            (true, Life::New) => {
                place.life = Life::Fresh;
                self.fresh.push(slot);
                self.committed += 1;
            }
            (false, Life::Fresh) => {
                self.vacate(slot);
                self.free.push(slot);
                self.committed -= 1;
            }
            (false, Life::Old) => {
                self.vacate(slot);
                self.vanished.push(slot);
                self.committed -= 1;
            }
            (true, Life::Fresh | Life::Old) | (false, Life::New) | (_, Life::Free) => {}
        }
    }

    /// What commits changed since the change taken before.
    pub fn take_change(&mut self) -> CloudChange {
        let by_id = |places: &[Place], slots: &mut Vec<Slot>| {
            slots.sort_unstable_by_key(|&slot| (places[slot as usize].vertex.id, slot));
            slots.dedup();
        };
        self.free.append(&mut self.emptied);
        let mut appeared = std::mem::take(&mut self.fresh);
        appeared.retain(|&slot| self.places[slot as usize].life == Life::Fresh);
        by_id(&self.places, &mut appeared);
        for &slot in &appeared {
            self.places[slot as usize].life = Life::Old;
        }
        let mut vanished = std::mem::take(&mut self.vanished);
        by_id(&self.places, &mut vanished);
        self.emptied.clone_from(&vanished);
        CloudChange { appeared, vanished }
    }

    fn vacate(&mut self, slot: Slot) {
        let place = &mut self.places[slot as usize];
        place.life = Life::Free;
        let position = place.vertex.position;
        if let Ok(entry) = self.by_position.find_entry(hash(position), |&other| other == slot) {
            entry.remove();
        }
        self.used -= 1;
    }

    /// The vertices as of the last commit, by id. Uncommitted ones are left out.
    pub fn vertices(&self) -> impl Iterator<Item = (Slot, Vertex)> + '_ {
        let listed = self.order.as_deref();
        (0..listed.map_or(self.places.len(), <[_]>::len)).filter_map(move |place| {
            let (id, slot) = listed.map_or_else(|| (self.places[place].vertex.id, place as Slot), |order| order[place]);
            let place = &self.places[slot as usize];
            (place.vertex.id == id && matches!(place.life, Life::Fresh | Life::Old)).then_some((slot, place.vertex))
        })
    }

    /// Position of the vertex in a slot (the last one, if it is gone).
    #[inline]
    pub fn position(&self, slot: Slot) -> Position {
        self.places[slot as usize].vertex.position
    }

    /// The vertex in a slot (the last one, if it is gone).
    pub fn vertex(&self, slot: Slot) -> Vertex {
        self.places[slot as usize].vertex
    }

    /// Name of the vertex in a slot (of the last one, if it is gone).
    pub fn id(&self, slot: Slot) -> VertexId {
        self.places[slot as usize].vertex.id
    }

    /// One more than the largest slot ever used.
    pub fn slot_count(&self) -> usize {
        self.places.len()
    }

    /// Number of vertices in use, those of the frame in hand among them.
    pub fn used_count(&self) -> usize {
        self.used
    }

    /// Number of distinct positions as of the last commit.
    pub fn vertex_count(&self) -> usize {
        self.committed
    }

    /// Number of points, duplicates and those of the frame in hand among them.
    pub fn point_count(&self) -> u64 {
        self.points
    }

    fn place_of(&self, x: f64, y: f64) -> Result<Position, Refusal> {
        let position = Position::new(x, y)?;
        Ok(match self.resolution {
            Some(step) => position.snapped(step)?,
            None => position,
        })
    }

    fn find(&self, position: Position) -> Option<Slot> {
        let slot = *self.by_position.find(hash(position), |&slot| self.position(slot) == position)?;
        (self.places[slot as usize].points > 0).then_some(slot)
    }

    /// One more point at `position`, with a new vertex if there is none.
    fn occupy(&mut self, position: Position) -> Result<Slot, Refusal> {
        let places = &mut self.places;
        let entry = self.by_position.entry(
            hash(position),
            |&slot| places[slot as usize].vertex.position == position,
            |&slot| hash(places[slot as usize].vertex.position),
        );
        let vacant = match entry {
            Entry::Occupied(entry) => {
                let slot = *entry.get();
                places[slot as usize].points += 1;
                return Ok(slot);
            }
            Entry::Vacant(vacant) => vacant,
        };
        if self.free.is_empty() && places.len() >= (Slot::MAX - 1) as usize {
            return Err(Refusal::Full(places.len()));
        }
        let id = VertexId(self.next_id);
        let place = Place { vertex: Vertex { id, position }, points: 1, retracted: 0, life: Life::New };
        let slot = match self.free.pop() {
            Some(slot) => {
                self.order.get_or_insert_with(|| in_slot_order(places));
                places[slot as usize] = place;
                slot
            }
            None => {
                places.push(place);
                (places.len() - 1) as Slot
            }
        };
        vacant.insert(slot);
        self.next_id += 1;
        self.used += 1;
        if let Some(order) = &mut self.order {
            order.push((id, slot));
        }
        self.touched.push(slot);
        Ok(slot)
    }

    /// One point less in a slot.
    pub(super) fn leave(&mut self, slot: Slot) {
        let place = &mut self.places[slot as usize];
        place.points -= 1;
        self.points -= 1;
        if place.points > 0 {
            return;
        }
        if place.life == Life::New {
            // Nobody has seen it: its slot is free at once, so that memory stays bounded without commits too.
            self.vacate(slot);
            self.free.push(slot);
            self.sweep_order();
        } else {
            self.touched.push(slot);
        }
        sweep(&mut self.touched, self.places.len());
    }

    /// Drops vanished vertices from the order of ids once they are the most of it.
    fn sweep_order(&mut self) {
        let Some(order) = self.order.as_mut().filter(|order| order.len() >= 2 * self.used + 1024) else { return };
        let places = &self.places;
        order.retain(|&(id, slot)| {
            let place = &places[slot as usize];
            place.vertex.id == id && place.life != Life::Free
        });
    }

    /// Of slots that appear in a change where others vanish: these.
    pub(crate) fn returned(&self, change: &CloudChange) -> BTreeMap<Slot, Slot> {
        let mut left = HashTable::with_capacity(change.vanished.len());
        for &slot in &change.vanished {
            left.insert_unique(hash(self.position(slot)), slot, |&slot| hash(self.position(slot)));
        }
        let same = |&slot: &Slot| {
            let position = self.position(slot);
            let old = left.find(hash(position), |&old| self.position(old) == position)?;
            Some((slot, *old))
        };
        change.appeared.iter().filter_map(same).collect()
    }

    /// Panics when the cloud contradicts itself. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        let used = || self.places.iter().filter(|place| place.life != Life::Free);
        assert_eq!(used().count(), self.used);
        assert_eq!(self.by_position.len(), self.used);
        assert_eq!(self.vertices().count(), self.committed);
        assert_eq!(used().map(|place| place.points).sum::<u64>(), self.points);
        let order = self.order.clone().unwrap_or_else(|| in_slot_order(&self.places));
        assert!(order.is_sorted_by_key(|&(id, _)| id));
        assert!(self.order.is_none() || order.len() <= 2 * self.used + 1024 + self.touched.len());
        if self.window != Window::All {
            assert!(self.queue.len() as u64 >= self.points);
        }
    }
}

fn in_slot_order(places: &[Place]) -> Vec<(VertexId, Slot)> {
    places.iter().zip(0..).map(|(place, slot)| (place.vertex.id, slot)).collect()
}

/// Forgets slots noted twice once they are the most of a list, so that it stays bounded by the places.
fn sweep(slots: &mut Vec<Slot>, places: usize) {
    if slots.len() > 2 * places + 1024 {
        slots.sort_unstable();
        slots.dedup();
    }
}

/// Mixes both coordinates; positions of a grid differ in few bits, and all of them must count.
#[inline]
fn hash(position: Position) -> u64 {
    let [x, y] = position.xy().map(f64::to_bits);
    let mixed = x.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ y.rotate_left(32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    mixed ^ (mixed >> 29)
}
