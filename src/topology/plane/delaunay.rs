//! The dynamic Delaunay triangulation of the cloud; the one file that imports `spade`.
//!
//! In: a [`Cloud`] and what its last commit changed. Out: a [`Mesh`] of all, or the surroundings of one vertex by half-edges, and word to a
//! [`Watcher`] of every vertex that comes or goes. Invariants: the sites are the cloud's vertices as of the
//! last change applied; `spade` never sees a duplicate, nor a cloud that lies on one line (there it would take
//! O(n log n) an insertion): such a cloud is kept as a sorted path until a point leaves the line. No handle of `spade`
//! leaves this file. Must not know: scales, ids of vertices.

use std::collections::BTreeSet;

use spade::handles::{DirectedEdgeHandle, FixedDirectedEdgeHandle, FixedVertexHandle};
use spade::{DelaunayTriangulation, HasPosition, LastUsedVertexHintGenerator, Point2, Triangulation};

use super::curve::{along_curve, is_thin};
use super::geometry::are_collinear;
use super::line::{Line, lies_on_a_line};
use super::mesh::{Mesh, MeshEdge};
use crate::topology::base::{in_order, ordinal};
use crate::topology::cloud::{Cloud, CloudChange, Located, Position, Slot};

/// A change of more than one in so many of the cloud's vertices is loaded in bulk (measured: they break even at about a quarter).
const BULK_SHARE: usize = 4;

/// A removal takes time as the square of the vertex' degree, about 1/400 of what bulk loading takes for one vertex.
const SQUARED_DEGREE_PER_BULK_VERTEX: usize = 400;

/// An insertion takes time as the new vertex' degree, about 1/30 of what bulk loading takes for one vertex.
const DEGREE_PER_BULK_VERTEX: usize = 30;

/// Packed: a vertex of `spade` then takes 24 bytes rather than 32.
#[derive(Clone, Copy, Debug)]
#[repr(C, packed(4))]
struct Site {
    position: Position,
    slot: Slot,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        let position = self.position;
        Point2::new(position.x(), position.y())
    }
}

// Batches are sorted along a curve that fills the plane, so the last vertex used is the best hint, and it costs no memory.
type Spade = DelaunayTriangulation<Site, (), (), (), LastUsedVertexHintGenerator>;

#[derive(Clone, Debug)]
enum Shape {
    /// All sites on one line, in order along it.
    Line(Line),
    /// At least one triangle.
    Plane(Spade),
}

/// How a change was applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// Vertex by vertex.
    Stepwise,
    /// By building the triangulation anew.
    Bulk,
}

/// Told of each step of a change. A bulk load is not told of.
pub trait Watcher {
    /// A vertex has come: its triangles are new, and so are the surroundings of its neighbours. Gives the number of these.
    fn has_come(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize;
    /// A vertex is about to go. Gives the number of its neighbours.
    fn will_go(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize;
    /// On a line, the neighbours of a vertex in this slot are new.
    fn has_new_neighbours(&mut self, slot: Slot);
    /// Where the search for a vertex that is about to be inserted best begins: at some vertex that was there before the change; at the last one
    /// that was inserted, if none is given.
    fn near(&mut self, position: Position, slot: Slot) -> Option<Slot>;
}

/// Nobody watches.
impl Watcher for () {
    fn has_come(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        plane.degree(out)
    }
    fn will_go(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        plane.degree(out)
    }
    fn has_new_neighbours(&mut self, _: Slot) {}
    fn near(&mut self, _: Position, _: Slot) -> Option<Slot> {
        None
    }
}

/// A directed edge. Changes of the triangulation give it another meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfEdge(FixedDirectedEdgeHandle);

/// A way to look around in a triangulation, half-edge by half-edge.
#[derive(Clone, Copy, Debug)]
pub struct HalfEdges<'a>(&'a Spade);

type Directed<'a> = DirectedEdgeHandle<'a, Site, (), (), ()>;

impl<'a> HalfEdges<'a> {
    #[inline]
    fn handle(self, edge: HalfEdge) -> Directed<'a> {
        self.0.directed_edge(edge.0)
    }

    #[inline]
    fn half_edge(edge: Directed<'_>) -> HalfEdge {
        HalfEdge(edge.fix())
    }

    /// The same edge in the other direction.
    #[inline]
    pub fn twin(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).rev())
    }

    /// The next one around the face on the left.
    #[inline]
    pub fn next(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).next())
    }

    /// The one before around the face on the left.
    #[inline]
    pub fn previous(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).prev())
    }

    /// The next one out of the same vertex, counter-clockwise.
    #[inline]
    pub fn turn(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).ccw())
    }

    /// Where it comes from.
    #[inline]
    pub fn origin(self, edge: HalfEdge) -> Located<Slot> {
        let site = *self.handle(edge).from().data();
        (site.position, site.slot)
    }

    /// How many edges its origin has.
    pub fn degree(self, edge: HalfEdge) -> usize {
        self.handle(edge).from().out_edges().count()
    }

    /// A number for the face on its left: another one for each, until the triangulation changes.
    #[inline]
    pub fn face_number(self, edge: HalfEdge) -> u32 {
        self.handle(edge).face().index() as u32
    }

    /// A number for the half-edge: another one for each, until the triangulation changes.
    #[inline]
    pub fn edge_number(self, edge: HalfEdge) -> u32 {
        edge.0.index() as u32
    }

    /// Whether the face on its left is the outer one.
    #[inline]
    pub fn is_outer(self, edge: HalfEdge) -> bool {
        self.handle(edge).is_outer_edge()
    }
}

/// The Delaunay triangulation of a cloud, kept up to date.
#[derive(Clone, Debug)]
pub struct Delaunay {
    shape: Shape,
    /// Of each slot: its vertex in the triangulation (meaningless on a line).
    handles: Vec<u32>,
}

impl Default for Delaunay {
    fn default() -> Self {
        Self { shape: Shape::Line(Line::default()), handles: Vec::new() }
    }
}

impl Delaunay {
    /// Follows the cloud from its commit before to its last one, in the way that is faster for the triangulation alone.
    pub fn apply(&mut self, cloud: &Cloud, change: &CloudChange) -> Update {
        self.apply_by(Self::faster(cloud, change), cloud, change, &mut ())
    }

    /// The way to follow a change that is faster for the triangulation alone.
    pub fn faster(cloud: &Cloud, change: &CloudChange) -> Update {
        let changed = change.appeared.len() + change.vanished.len();
        if changed * BULK_SHARE > cloud.vertex_count() { Update::Bulk } else { Update::Stepwise }
    }

    /// The same in a way that is chosen outside, with somebody watching the steps. Where steps turn out to take too long, or end
    /// on a line, it is done in bulk after all; what was told before means nothing then.
    pub fn apply_by(
        &mut self,
        update: Update,
        cloud: &Cloud,
        change: &CloudChange,
        watcher: &mut impl Watcher,
    ) -> Update {
        self.handles.resize(cloud.slot_count(), 0);
        if update == Update::Bulk || !self.step(cloud, change, watcher) {
            self.rebuild(cloud);
            Update::Bulk
        } else {
            Update::Stepwise
        }
    }

    /// Number of sites.
    pub fn site_count(&self) -> usize {
        match &self.shape {
            Shape::Line(line) => line.len(),
            Shape::Plane(spade) => spade.num_vertices(),
        }
    }

    /// Applies a change vertex by vertex; false when it has to be done in bulk after all (the triangulation is then half changed).
    fn step(&mut self, cloud: &Cloud, change: &CloudChange, watcher: &mut impl Watcher) -> bool {
        match &mut self.shape {
            Shape::Line(line) => line.step(cloud, change, |slot| watcher.has_new_neighbours(slot)),
            Shape::Plane(spade) => step_in_plane(spade, &mut self.handles, cloud, change, watcher),
        }
    }

    /// The plane, to look around in; none, while all sites lie on one line.
    #[inline]
    pub fn half_edges(&self) -> Option<HalfEdges<'_>> {
        match &self.shape {
            Shape::Line(_) => None,
            Shape::Plane(spade) => Some(HalfEdges(spade)),
        }
    }

    /// A half-edge out of the vertex in a slot; none on a line.
    #[inline]
    pub fn edge_out_of(&self, slot: Slot) -> Option<HalfEdge> {
        self.half_edges().map(|HalfEdges(spade)| out_of(spade, vertex_handle(&self.handles, slot)))
    }

    /// On a line, what is on either side of a position; nothing in the plane.
    pub fn on_either_side(&self, position: Position) -> [Option<Located<Slot>>; 2] {
        match &self.shape {
            Shape::Line(line) => line.neighbours(position),
            Shape::Plane(_) => [None; 2],
        }
    }

    fn rebuild(&mut self, cloud: &Cloud) {
        let sites = far_first(cloud);
        if lies_on_a_line(sites.iter().map(|site| site.position)) {
            self.shape = Shape::Line(Line::new(sites.iter().map(|site| (site.position, site.slot))));
            return;
        }
        // A new triangulation even where the old one could be cleared: spade's `clear` leaves a stale hull behind.
        let spade = if is_thin(sites.iter().map(|site| site.position)) {
            load_in_rounds(sites)
        } else {
            Spade::bulk_load(sites).expect("positions are inside the limits, which are spade's")
        };
        for vertex in spade.vertices() {
            self.handles[vertex.data().slot as usize] = vertex.index() as u32;
        }
        self.shape = Shape::Plane(spade);
    }

    /// The triangulation as flat arrays.
    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        self.read_into(&mut mesh);
        mesh
    }

    /// The same, in the place and the memory of another mesh.
    pub fn read_into(&self, mesh: &mut Mesh) {
        match &self.shape {
            Shape::Line(line) => line.read_into(mesh),
            Shape::Plane(spade) => read_plane(spade, mesh),
        }
    }

    /// Panics when the triangulation contradicts itself or the cloud. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self, cloud: &Cloud) {
        assert_eq!(self.site_count(), cloud.vertex_count());
        match &self.shape {
            Shape::Line(line) => line.check_invariants(cloud),
            Shape::Plane(spade) => {
                assert!(!spade.all_vertices_on_line());
                for (slot, vertex) in cloud.vertices() {
                    let handle = vertex_handle(&self.handles, slot);
                    let site = *spade.vertex(handle).data();
                    assert_eq!((site.slot, site.position), (slot, vertex.position));
                }
            }
        }
    }
}

/// The sites of a cloud, those far from their mean first.
///
/// That is the order in which bulk loading takes them, from the end. It sorts them itself, by comparisons, but what is in order already it
/// only looks at; its mean differs from this one by rounding, so it finds a pair out of place only where two distances agree to
/// the last bits. A radix sort takes a fifth of the time.
fn far_first(cloud: &Cloud) -> Vec<Site> {
    let mut slots = Vec::with_capacity(cloud.vertex_count());
    slots.extend(cloud.vertices().map(|(slot, _)| slot));
    let sum = |axis: usize| slots.iter().map(|&slot| cloud.position(slot).xy()[axis]).sum::<f64>();
    let mean = [0, 1].map(|axis| sum(axis) * (1.0 / slots.len() as f64));
    let descending = |place: u32| {
        let position = cloud.position(slots[place as usize]);
        let (dx, dy) = (mean[0] - position.x(), mean[1] - position.y());
        !ordinal(dx * dx + dy * dy)
    };
    let site = |place: u32| Site { position: cloud.position(slots[place as usize]), slot: slots[place as usize] };
    in_order(slots.len(), descending, u64::from).into_iter().map(site).collect()
}

/// Inserts sites one by one in rounds, each of as many as all before it: drawn at random, then ordered along a curve. Takes near-linear time
/// on every cloud (N. Amenta, S. Choi, G. Rote, "Incremental Constructions con BRIO", SoCG 2003), about half as long again as
/// bulk loading does on a good one.
fn load_in_rounds(mut sites: Vec<Site>) -> Spade {
    let on_line = |sites: &[Site], third: &Site| are_collinear(sites[0].position, sites[1].position, third.position);
    if let Some(off) = sites.iter().skip(2).position(|site| !on_line(&sites, site)) {
        sites.swap(2, off + 2);
        shuffle(&mut sites[3..]);
    }
    let mut spade = Spade::new();
    let mut done = 0;
    while done < sites.len() {
        let round = &sites[done..sites.len().min((2 * done).max(3))];
        for place in along_curve(round.iter().map(|site| site.position)) {
            spade.insert(round[place]).expect("positions are inside the limits, which are spade's");
        }
        done += round.len();
    }
    spade
}

/// In some order that has nothing to do with the one before, and is the same every time.
fn shuffle(sites: &mut [Site]) {
    let mut state = 0_u64;
    for last in (1..sites.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sites.swap(last, (state >> 32) as usize % (last + 1));
    }
}

fn step_in_plane(
    spade: &mut Spade,
    handles: &mut [u32],
    cloud: &Cloud,
    change: &CloudChange,
    watcher: &mut impl Watcher,
) -> bool {
    let (appeared, vanished) = hand_on(spade, handles, cloud, change, watcher);
    // Insertions first: the cloud then meets a line only if it ends on one.
    let mut budget = DEGREE_PER_BULK_VERTEX * cloud.vertex_count();
    for place in along_curve(appeared.iter().map(|&slot| cloud.position(slot))) {
        let slot = appeared[place];
        let site = Site { position: cloud.position(slot), slot };
        let inserted = match watcher.near(site.position, slot) {
            Some(near) => spade.insert_with_hint(site, vertex_handle(handles, near)),
            None => spade.insert(site),
        };
        let handle = inserted.expect("positions are inside the limits, which are spade's");
        handles[slot as usize] = handle.index() as u32;
        let degree = watcher.has_come(HalfEdges(spade), out_of(spade, handle));
        let Some(left) = budget.checked_sub(degree) else { return false };
        budget = left;
    }
    let mut budget = SQUARED_DEGREE_PER_BULK_VERTEX * cloud.vertex_count();
    for place in along_curve(vanished.iter().map(|&slot| cloud.position(slot))) {
        let slot = vanished[place];
        let handle = vertex_handle(handles, slot);
        let degree = watcher.will_go(HalfEdges(spade), out_of(spade, handle));
        let Some(left) = budget.checked_sub(degree.pow(2)) else { return false };
        budget = left;
        remove(spade, handles, handle);
        if spade.all_vertices_on_line() {
            return false;
        }
    }
    true
}

fn vertex_handle(handles: &[u32], slot: Slot) -> FixedVertexHandle {
    FixedVertexHandle::from_index(handles[slot as usize] as usize)
}

fn out_of(spade: &Spade, handle: FixedVertexHandle) -> HalfEdge {
    HalfEdges::half_edge(spade.vertex(handle).out_edge().expect("a vertex of a triangulation has edges"))
}

/// A position that was left and taken again between two changes taken keeps its site, under the new slot. Gives the slots that really
/// appear and vanish.
fn hand_on(
    spade: &mut Spade,
    handles: &mut [u32],
    cloud: &Cloud,
    change: &CloudChange,
    watcher: &mut impl Watcher,
) -> (Vec<Slot>, Vec<Slot>) {
    let (mut appeared, mut vanished) = (change.appeared.clone(), change.vanished.clone());
    let returned = cloud.returned(change);
    if returned.is_empty() {
        return (appeared, vanished);
    }
    let kept: BTreeSet<Slot> = returned.values().copied().collect();
    vanished.retain(|slot| !kept.contains(slot));
    appeared.retain(|&slot| {
        let Some(&old) = returned.get(&slot) else { return true };
        let handle = handles[old as usize];
        handles[slot as usize] = handle;
        let handle = FixedVertexHandle::from_index(handle as usize);
        watcher.will_go(HalfEdges(spade), out_of(spade, handle));
        spade.vertex_data_mut(handle).slot = slot;
        watcher.has_come(HalfEdges(spade), out_of(spade, handle));
        false
    });
    (appeared, vanished)
}

fn remove(spade: &mut Spade, handles: &mut [u32], handle: FixedVertexHandle) {
    spade.remove(handle);
    // spade moves its last vertex into the gap.
    if let Some(moved) = spade.get_vertex(handle) {
        handles[moved.data().slot as usize] = handle.index() as u32;
    }
}

fn read_plane(spade: &Spade, mesh: &mut Mesh) {
    mesh.reset(spade.num_vertices(), spade.num_undirected_edges(), spade.num_all_faces());
    for vertex in spade.vertices() {
        let site = vertex.data();
        mesh.push_site(site.position, site.slot);
    }
    for edge in spade.undirected_edges() {
        // Both directions of an edge lie side by side in memory; nothing else is read.
        let (there, back) = (edge.as_directed(), edge.as_directed().rev());
        mesh.push_edge(MeshEdge {
            ends: [there.from(), back.from()].map(|vertex| vertex.index() as u32),
            faces: [there.face(), back.face()].map(|face| face.index() as u32),
        });
    }
}
