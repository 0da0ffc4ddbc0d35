//! The cloud: the current vertices, and what changed since the last change was taken.
//!
//! In: points one by one (to insert or to retract), event times, commits.
//! Out: the vertices as of the last commit. On request, a [`CloudChange`] that sums up all commits since the change
//! before.
//! Invariants: equal sites share one vertex, which lives until its last point leaves. Vertices appear and vanish at
//! commits only: a position that is left and taken again between two commits keeps its vertex. Ids rise in order of
//! first appearance and are never reused. A slot is reused only after the change that follows the one which emptied it.
//! A vertex that is set aside stays so until it is put back or vanishes.
//! Must not know: triangulations, the contents of frames.

use std::collections::BTreeMap;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;

use super::clocks::Clocks;
use super::position::Position;
use super::refusal::Refusal;
use super::site::Site;
use super::vertex::{Awaiting, CloudChange, Slot, Vertex, VertexId};
use super::window::{Queue, Window};

#[derive(Clone, Copy, Debug)]
pub(super) struct Place<S> {
    pub(super) vertex: Vertex<S>,
    /// The number of points at this position.
    points: u64,
    /// Points that wait at this position for their commits.
    awaited: u32,
    /// Points that are retracted but whose arrivals are still in the window's queue.
    pub(super) retracted: u32,
    state: PlaceState,
    /// Whether its vertex is set aside.
    is_aside: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PlaceState {
    /// It appeared since the last commit.
    New,
    /// It was there at the last commit, but no change has reported it yet.
    Unreported,
    /// It was there at the last commit, and a change has reported it.
    Reported,
    /// The slot is not in use.
    Free,
}

/// The points of a stream, as distinct positions; outside of the plane as other distinct [`Site`]s.
#[derive(Clone, Debug)]
pub struct Cloud<S = Position> {
    pub(super) window: Window,
    resolution: Option<f64>,
    pub(super) places: Vec<Place<S>>,
    free: Vec<Slot>,
    by_position: HashTable<Slot>,
    pub(super) queue: Queue,
    /// Slots whose vertex may have appeared or vanished since the last commit; may repeat.
    touched: Vec<Slot>,
    /// Slots that became unreported at a commit. Some may have vanished since; may repeat.
    unreported: Vec<Slot>,
    /// Slots emptied by commits since the last change was taken.
    vanished: Vec<Slot>,
    /// Slots emptied in the last change taken.
    emptied: Vec<Slot>,
    /// Slots in order of id, vanished ones included until a sweep. None while no slot was reused: slots are in that
    /// order then.
    order: Option<Vec<(VertexId, Slot)>>,
    /// Vertices in use, including those that are not committed yet.
    used: usize,
    /// Vertices with points.
    pub(super) occupied: usize,
    /// The most vertices with points that there may be.
    pub(super) most: usize,
    /// Vertices as of the last commit, and how many of them are set aside.
    committed: usize,
    aside: usize,
    pub(super) points: u64,
    next_id: u64,
    pub(super) newest_time: Option<f64>,
    /// The time of the commit whose points come right now.
    pub(super) coming: Option<f64>,
    /// In a time window: what was believed before it last started anew.
    pub(super) before: Option<f64>,
    /// Of the sources of a time window.
    pub(super) clocks: Clocks,
    pub(super) frame: u64,
}

impl<S: Site> Cloud<S> {
    /// An empty cloud; `resolution` snaps coordinates to a grid of that step.
    pub fn new(window: Window, resolution: Option<f64>) -> Self {
        Self {
            window,
            resolution,
            places: Vec::new(),
            free: Vec::new(),
            by_position: HashTable::new(),
            queue: Queue::new(window),
            touched: Vec::new(),
            unreported: Vec::new(),
            vanished: Vec::new(),
            emptied: Vec::new(),
            order: None,
            used: 0,
            occupied: 0,
            most: usize::MAX,
            committed: 0,
            aside: 0,
            points: 0,
            next_id: 0,
            newest_time: None,
            coming: None,
            before: None,
            clocks: Clocks::new(if let Window::Time(length) = window { length } else { 0.0 }),
            frame: 1,
        }
    }

    /// Makes room for so many more points.
    pub fn reserve(&mut self, points: usize) {
        self.places.reserve(points.saturating_sub(self.free.len()));
        self.touched.reserve(points);
        let places = &self.places;
        self.by_position.reserve(points, |&slot| places[slot as usize].vertex.position.digest());
    }

    /// Adds a point; `time` is its event time. In a time window, a point without one gets the newest time known.
    ///
    /// # Errors [`Refusal`]; the cloud is then unchanged.
    pub fn insert_site(&mut self, site: S, time: Option<f64>) -> Result<Slot, Refusal> {
        let position = self.place_of(site)?;
        let key = self.key(time)?;
        self.make_room(&position)?;
        let slot = self.occupy(position, |place| place.points += 1)?;
        self.arrive(slot, key);
        Ok(slot)
    }

    /// A point has come to a slot, with its key in the window.
    pub(super) fn arrive(&mut self, slot: Slot, key: f64) {
        self.points += 1;
        let vertex = self.places[slot as usize].vertex.id;
        if self.places[slot as usize].retracted > 0 && self.is_late(key) {
            // At a position, retracted points leave first. A late point must not take their place in the queue.
            self.drop_retracted();
        }
        self.queue.push(key, slot, vertex);
        self.expire();
    }

    /// Retracts the oldest point at a site.
    ///
    /// # Errors [`Refusal`]; the cloud is then unchanged.
    pub fn retract_site(&mut self, site: S) -> Result<Slot, Refusal> {
        let not_there = site.not_there();
        self.retract_at(&self.place_of(site)?).ok_or(not_there)
    }

    /// Retracts the oldest point at a position, if there is one.
    pub(super) fn retract_at(&mut self, position: &S) -> Option<Slot> {
        let slot = self.find(position)?;
        self.places[slot as usize].retracted += u32::from(self.window != Window::All);
        self.leave(slot);
        self.sweep_queue();
        Some(slot)
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
        sweep(&mut self.unreported, self.places.len());
    }

    /// Decides at a commit whether a vertex appears, stays or vanishes.
    fn settle(&mut self, slot: Slot) {
        let place = &mut self.places[slot as usize];
        match (place.points > 0, place.state) {
            (true, PlaceState::New) => {
                place.state = PlaceState::Unreported;
                self.unreported.push(slot);
                self.committed += 1;
            }
            (false, PlaceState::Unreported) => {
                self.vacate(slot);
                self.free.push(slot);
                self.committed -= 1;
            }
            (false, PlaceState::Reported) => {
                self.vacate(slot);
                self.vanished.push(slot);
                self.committed -= 1;
            }
            (true, PlaceState::Unreported | PlaceState::Reported)
            | (false, PlaceState::New)
            | (_, PlaceState::Free) => {}
        }
    }

    /// What all commits changed since the last change was taken.
    pub fn take_change(&mut self) -> CloudChange {
        let by_id = |places: &[Place<S>], slots: &mut Vec<Slot>| {
            slots.sort_unstable_by_key(|&slot| (places[slot as usize].vertex.id, slot));
            slots.dedup();
        };
        self.free.append(&mut self.emptied);
        let mut appeared = std::mem::take(&mut self.unreported);
        appeared.retain(|&slot| self.places[slot as usize].state == PlaceState::Unreported);
        by_id(&self.places, &mut appeared);
        for &slot in &appeared {
            self.places[slot as usize].state = PlaceState::Reported;
        }
        let mut vanished = std::mem::take(&mut self.vanished);
        by_id(&self.places, &mut vanished);
        self.emptied.clone_from(&vanished);
        CloudChange { appeared, vanished }
    }

    fn vacate(&mut self, slot: Slot) {
        self.set_aside(slot, false);
        let place = &mut self.places[slot as usize];
        place.state = PlaceState::Free;
        if let Ok(entry) = self.by_position.find_entry(place.vertex.position.digest(), |&other| other == slot) {
            entry.remove();
        }
        self.used -= 1;
    }

    /// Sets the vertex in a slot aside, or puts it back. One that is set aside is there in all respects, but is no
    /// vertex for what is computed from the cloud.
    pub(crate) fn set_aside(&mut self, slot: Slot, is_aside: bool) {
        let was = std::mem::replace(&mut self.places[slot as usize].is_aside, is_aside);
        self.aside = self.aside + usize::from(is_aside) - usize::from(was);
    }

    /// The vertices as of the last commit, by id, without those that are set aside.
    pub fn vertices(&self) -> impl Iterator<Item = (Slot, Vertex<S>)> + '_ {
        self.all_vertices().filter(|&(slot, _)| !self.places[slot as usize].is_aside)
    }

    /// The vertices as of the last commit, by id.
    pub(crate) fn all_vertices(&self) -> impl Iterator<Item = (Slot, Vertex<S>)> + '_ {
        let listed = self.order.as_deref();
        (0..listed.map_or(self.places.len(), <[_]>::len)).filter_map(move |place| {
            let (id, slot) = listed.map_or_else(|| (self.places[place].vertex.id, place as Slot), |order| order[place]);
            let place = &self.places[slot as usize];
            (place.vertex.id == id && matches!(place.state, PlaceState::Unreported | PlaceState::Reported))
                .then(|| (slot, place.vertex.clone()))
        })
    }

    /// Where the vertex in a slot is; the last one, if it is gone.
    #[inline]
    pub fn site(&self, slot: Slot) -> &S {
        &self.places[slot as usize].vertex.position
    }

    /// The vertex in a slot; the last one, if it is gone.
    pub fn vertex(&self, slot: Slot) -> Vertex<S> {
        self.places[slot as usize].vertex.clone()
    }

    /// The id of the vertex in a slot; of the last one, if it is gone.
    pub fn id(&self, slot: Slot) -> VertexId {
        self.places[slot as usize].vertex.id
    }

    /// One more than the largest slot in use so far.
    pub fn slot_count(&self) -> usize {
        self.places.len()
    }

    /// The number of vertices, including those that are not committed yet.
    pub fn used_count(&self) -> usize {
        self.used
    }

    /// The number of vertices as of the last commit, without those that are set aside.
    pub fn vertex_count(&self) -> usize {
        self.committed - self.aside
    }

    /// The number of points, including duplicates and those that are not committed yet.
    pub fn point_count(&self) -> u64 {
        self.points
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let lists = [&self.touched, &self.unreported, &self.vanished, &self.emptied, &self.free];
        // The table is full to seven eighths at the most, and has a byte beside each slot.
        let coordinates = self.places.first().map_or(0, |place| place.vertex.position.heap_size());
        self.places.len() * (size_of::<Place<S>>() + coordinates)
            + self.by_position.capacity() * 8 / 7 * (size_of::<Slot>() + 1)
            + lists.map(Vec::capacity).iter().sum::<usize>() * size_of::<Slot>()
            + self.order.as_ref().map_or(0, Vec::len) * size_of::<(VertexId, Slot)>()
            + self.queue.bytes()
            + self.clocks.bytes()
    }

    /// The site that a point at a site is counted at.
    pub fn place_of(&self, site: S) -> Result<S, Refusal> {
        match self.resolution {
            Some(step) => site.on_grid(step),
            None => Ok(site),
        }
    }

    fn find(&self, position: &S) -> Option<Slot> {
        let slot = self.slot_at(position)?;
        (self.places[slot as usize].points > 0).then_some(slot)
    }

    /// Counts a point at `position`, with a new vertex if there is none.
    fn occupy(&mut self, position: S, count: impl Fn(&mut Place<S>)) -> Result<Slot, Refusal> {
        let places = &mut self.places;
        let entry = self.by_position.entry(
            position.digest(),
            |&slot| places[slot as usize].vertex.position == position,
            |&slot| places[slot as usize].vertex.position.digest(),
        );
        let vacant = match entry {
            Entry::Occupied(entry) => {
                let slot = *entry.get();
                let place = &mut places[slot as usize];
                let was_empty = place.points == 0;
                count(place);
                self.occupied += usize::from(was_empty && place.points > 0);
                if was_empty && place.state == PlaceState::New {
                    // A commit may have passed it by, while its point was awaited.
                    self.touched.push(slot);
                }
                return Ok(slot);
            }
            Entry::Vacant(vacant) => vacant,
        };
        if self.free.is_empty() && places.len() >= (Slot::MAX - 1) as usize {
            return Err(Refusal::Full(places.len()));
        }
        let id = VertexId(self.next_id);
        let vertex = Vertex { id, position };
        let mut place = Place { vertex, points: 0, awaited: 0, retracted: 0, state: PlaceState::New, is_aside: false };
        count(&mut place);
        self.occupied += usize::from(place.points > 0);
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

    /// Frees the slot of a vertex that no commit has seen, if no point is there or awaited: at once, so that memory
    /// stays bounded without commits as well.
    fn free_if_unused(&mut self, slot: Slot) {
        let place = &self.places[slot as usize];
        if place.state == PlaceState::New && place.points == 0 && place.awaited == 0 {
            self.vacate(slot);
            self.free.push(slot);
            self.sweep_order();
            sweep(&mut self.touched, self.places.len());
        }
    }

    /// Has a vertex at `position` wait for a point.
    pub(super) fn await_point(&mut self, position: S) -> Result<Awaiting<S>, Refusal> {
        let slot = self.occupy(position, |place| place.awaited += 1)?;
        let Vertex { id, position } = self.vertex(slot);
        Ok(Awaiting { position, slot, vertex: id })
    }

    /// The awaited point has come: to its vertex, or to another one if that has vanished.
    pub(super) fn take_awaited(&mut self, awaiting: &Awaiting<S>) -> Result<Slot, Refusal> {
        let awaited = u32::from(self.is_awaited(awaiting));
        self.occupy(awaiting.position.clone(), |place| {
            place.points += 1;
            place.awaited -= awaited;
        })
    }

    /// The awaited point does not come.
    pub(super) fn give_up(&mut self, awaiting: &Awaiting<S>) {
        if self.is_awaited(awaiting) {
            self.places[awaiting.slot as usize].awaited -= 1;
            self.free_if_unused(awaiting.slot);
        }
    }

    /// Whether the vertex that waits for a point is there.
    fn is_awaited(&self, awaiting: &Awaiting<S>) -> bool {
        let place = &self.places[awaiting.slot as usize];
        place.vertex.id == awaiting.vertex && place.state != PlaceState::Free
    }

    /// The slot of a position, if points are there or awaited.
    fn slot_at(&self, position: &S) -> Option<Slot> {
        self.by_position.find(position.digest(), |&slot| self.site(slot) == position).copied()
    }

    /// Points at a position.
    pub(super) fn points_at(&self, position: &S) -> u64 {
        self.slot_at(position).map_or(0, |slot| self.places[slot as usize].points)
    }

    /// Removes a point from a slot.
    pub(super) fn leave(&mut self, slot: Slot) {
        let place = &mut self.places[slot as usize];
        place.points -= 1;
        self.points -= 1;
        if place.points > 0 {
            return;
        }
        self.occupied -= 1;
        if place.state == PlaceState::New {
            self.free_if_unused(slot);
        } else {
            self.touched.push(slot);
        }
        sweep(&mut self.touched, self.places.len());
    }

    /// Drops vanished vertices from the order of ids once they are most of it.
    fn sweep_order(&mut self) {
        let Some(order) = self.order.as_mut().filter(|order| order.len() >= 2 * self.used + 1024) else { return };
        let places = &self.places;
        order.retain(|&(id, slot)| {
            let place = &places[slot as usize];
            place.vertex.id == id && place.state != PlaceState::Free
        });
    }

    /// Slots that appear in a change at the position of a slot that vanishes in it, each with that slot.
    pub(crate) fn returned(&self, change: &CloudChange) -> BTreeMap<Slot, Slot> {
        let mut left = HashTable::with_capacity(change.vanished.len());
        for &slot in &change.vanished {
            left.insert_unique(self.site(slot).digest(), slot, |&slot| self.site(slot).digest());
        }
        let same = |&slot: &Slot| {
            let site = self.site(slot);
            let old = left.find(site.digest(), |&old| self.site(old) == site)?;
            Some((slot, *old))
        };
        change.appeared.iter().filter_map(same).collect()
    }

    /// Panics when the cloud is inconsistent. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        let used = || self.places.iter().filter(|place| place.state != PlaceState::Free);
        assert_eq!(used().count(), self.used);
        assert_eq!(self.by_position.len(), self.used);
        assert_eq!(self.all_vertices().count(), self.committed);
        assert_eq!(self.vertices().count(), self.vertex_count());
        assert_eq!(self.places.iter().filter(|place| place.is_aside).count(), self.aside);
        assert_eq!(used().filter(|place| place.points > 0).count(), self.occupied);
        assert_eq!(used().map(|place| place.points).sum::<u64>(), self.points);
        let order = self.order.clone().unwrap_or_else(|| in_slot_order(&self.places));
        assert!(order.is_sorted_by_key(|&(id, _)| id));
        assert!(self.order.is_none() || order.len() <= 2 * self.used + 1024 + self.touched.len());
        if self.window != Window::All {
            assert!(self.queue.len() as u64 >= self.points);
        }
    }
}

fn in_slot_order<S>(places: &[Place<S>]) -> Vec<(VertexId, Slot)> {
    places.iter().zip(0..).map(|(place, slot)| (place.vertex.id, slot)).collect()
}

/// Removes repeated slots once they are most of a list, so that the list stays bounded by the places.
fn sweep(slots: &mut Vec<Slot>, places: usize) {
    if slots.len() > 2 * places + 1024 {
        slots.sort_unstable();
        slots.dedup();
    }
}
