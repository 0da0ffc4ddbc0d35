//! The dynamic Delaunay triangulation of the cloud. The only file that imports `spade`.
//!
//! In: a [`Cloud`] and its last change.
//! Out: a [`Mesh`] of everything; half-edges around a vertex; a call to an [`Observer`] for every vertex that is
//! inserted or removed.
//! Invariants: the sites are the cloud's vertices as of the last change applied. `spade` never gets a duplicate, nor a
//! cloud on one line (an insertion would take O(n log n) there): such a cloud is a sorted path ([`Line`]) until a point
//! leaves the line. No handle of `spade` leaves this file.
//! Must not know: scales, ids of vertices.

use std::collections::BTreeSet;

use spade::handles::{DirectedEdgeHandle, FixedDirectedEdgeHandle, FixedVertexHandle, VertexHandle};
use spade::{DelaunayTriangulation, HasPosition, LastUsedVertexHintGenerator, Point2, Triangulation};

use super::curve::{along_curve, is_thin};
use super::geometry::are_collinear;
use super::line::{Line, lies_on_a_line};
use super::mesh::{Mesh, MeshEdge};
use crate::topology::base::{in_order, ordinal};
use crate::topology::cloud::{Cloud, CloudChange, Located, Position, Slot};

/// A change of more than one in four of the cloud's vertices is loaded in bulk (measured: both ways take the same time
/// at about a quarter).
const BULK_SHARE: usize = 4;

/// The steps of a change are given up when they take longer than one pass takes for a quarter of the cloud. So a change
/// that is given up takes little longer than the pass that follows. The constant keeps small clouds from being rebuilt
/// all the time.
fn step_budget(vertices: usize) -> f64 {
    64.0 + vertices as f64 / 4.0
}

/// What the insertion of a vertex takes, as a number of vertices of one pass (measured where the neighbours are not in
/// the cache). The search turns around vertices whose degree is as high.
fn insertion_cost(degree: usize) -> f64 {
    degree as f64 / 10.0
}

/// What the removal of a vertex takes at most, as a number of vertices of one pass (measured on spirals, which are the
/// worst). `spade` flips edges in proportion to the square of the degree. At each flip it searches a list of new edges.
fn removal_cost(degree: usize) -> f64 {
    let degree = degree as f64;
    degree.powi(2) / 400.0 + degree.powi(3) / 3200.0
}

/// Packed, so that a vertex of `spade` takes 24 bytes instead of 32.
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

// Batches are sorted along a space-filling curve. The last vertex used is then the best hint, and it needs no memory.
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

/// Is called at each step of a change; not for bulk loads.
pub trait Observer {
    /// A vertex was inserted; `out` is a half-edge out of it. Its triangles are new, and so are the surroundings of its
    /// neighbours. Returns the number of neighbours.
    fn on_inserted(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize;
    /// A vertex is about to be removed. Returns the number of its neighbours.
    fn before_removal(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize;
    /// On a line, the vertex in this slot has new neighbours.
    fn on_new_neighbours(&mut self, slot: Slot);
    /// The vertex at which the search for a new vertex begins. It must have been there before the change. Without one,
    /// the search begins at the last vertex that was inserted.
    fn hint_for(&mut self, position: Position, slot: Slot) -> Option<Slot>;
}

/// Observes nothing.
impl Observer for () {
    fn on_inserted(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        plane.degree(out)
    }
    fn before_removal(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        plane.degree(out)
    }
    fn on_new_neighbours(&mut self, _: Slot) {}
    fn hint_for(&mut self, _: Position, _: Slot) -> Option<Slot> {
        None
    }
}

/// A directed edge. It is valid until the triangulation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HalfEdge(FixedDirectedEdgeHandle);

/// The triangulation as half-edges.
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

    /// The next half-edge around the face on the left.
    #[inline]
    pub fn next(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).next())
    }

    /// The previous half-edge around the face on the left.
    #[inline]
    pub fn previous(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).prev())
    }

    /// The next half-edge out of the same vertex, counter-clockwise.
    #[inline]
    pub fn turn(self, edge: HalfEdge) -> HalfEdge {
        Self::half_edge(self.handle(edge).ccw())
    }

    /// The site that it leads out of.
    #[inline]
    pub fn origin(self, edge: HalfEdge) -> Located<Slot> {
        let site = *self.handle(edge).from().data();
        (site.position, site.slot)
    }

    /// The degree of its origin.
    pub fn degree(self, edge: HalfEdge) -> usize {
        self.handle(edge).from().out_edges().count()
    }

    /// The number of the face on its left; valid until the triangulation changes.
    #[inline]
    pub fn face_number(self, edge: HalfEdge) -> u32 {
        self.handle(edge).face().index() as u32
    }

    /// The number of the half-edge; valid until the triangulation changes.
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
    /// The vertex in the triangulation of each slot; not valid on a line.
    handles: Vec<u32>,
}

impl Default for Delaunay {
    fn default() -> Self {
        Self { shape: Shape::Line(Line::default()), handles: Vec::new() }
    }
}

impl Delaunay {
    /// The number of vertices that it has.
    pub fn vertex_count(&self) -> usize {
        match &self.shape {
            Shape::Line(line) => line.len(),
            Shape::Plane(spade) => spade.num_vertices(),
        }
    }

    /// Applies a change of the cloud in the way that is faster for the triangulation alone.
    pub fn apply(&mut self, cloud: &Cloud, change: &CloudChange) -> Update {
        self.apply_by(Self::faster(cloud, change), cloud, change, &mut ())
    }

    /// The way to apply a change that is faster for the triangulation alone.
    pub fn faster(cloud: &Cloud, change: &CloudChange) -> Update {
        let changed = change.appeared.len() + change.vanished.len();
        if changed * BULK_SHARE > cloud.vertex_count() { Update::Bulk } else { Update::Stepwise }
    }

    /// Applies a change in a given way and calls the observer at each step. If steps turn out to take too long, or end
    /// on a line, the triangulation is rebuilt in bulk; what was reported to the observer is not valid then. Returns
    /// the way that was taken.
    pub fn apply_by(
        &mut self,
        update: Update,
        cloud: &Cloud,
        change: &CloudChange,
        observer: &mut impl Observer,
    ) -> Update {
        self.handles.resize(cloud.slot_count(), 0);
        if update == Update::Bulk || !self.step(cloud, change, observer) {
            self.rebuild(cloud);
            Update::Bulk
        } else {
            Update::Stepwise
        }
    }

    /// The number of sites.
    pub fn site_count(&self) -> usize {
        match &self.shape {
            Shape::Line(line) => line.len(),
            Shape::Plane(spade) => spade.num_vertices(),
        }
    }

    /// Applies a change vertex by vertex. Returns false when the triangulation has to be rebuilt; it is half changed
    /// then.
    fn step(&mut self, cloud: &Cloud, change: &CloudChange, observer: &mut impl Observer) -> bool {
        match &mut self.shape {
            Shape::Line(line) => line.step(cloud, change, |slot| observer.on_new_neighbours(slot)),
            Shape::Plane(spade) => step_in_plane(spade, &mut self.handles, cloud, change, observer),
        }
    }

    /// The half-edges; none while all sites lie on one line.
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

    /// On a line, the sites on either side of a position; none in the plane.
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
        // A new triangulation, although the old one could be cleared: `clear` of `spade` leaves a stale hull behind.
        let spade = if is_thin(sites.iter().map(|site| site.position)) {
            load_in_rounds(sites)
        } else {
            let bulk = Spade::bulk_load(sites).expect("positions are inside the limits, which are spade's");
            if has_convex_hull(&bulk) { bulk } else { load_in_rounds(far_first(cloud)) }
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

    /// The same, written over another mesh.
    pub fn read_into(&self, mesh: &mut Mesh) {
        match &self.shape {
            Shape::Line(line) => line.read_into(mesh),
            Shape::Plane(spade) => read_plane(spade, mesh),
        }
    }

    /// Panics when the triangulation is inconsistent or differs from the cloud. For tests.
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
/// Bulk loading takes them in this order, from the end. It sorts them by comparisons, but sites that are in order
/// already cost one look each. Its mean differs from this one by rounding, so it finds a pair out of order only where
/// two distances agree to the last bits. This radix sort takes a fifth of the time.
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

/// Whether the hull turns one way everywhere, and goes round once: it has one smallest and one largest site. Bulk
/// loading may leave a loop in it where sites lie nearly on a line, and the triangulation is not Delaunay then. Takes
/// time in proportion to the hull.
fn has_convex_hull(spade: &Spade) -> bool {
    let position = |vertex: VertexHandle<'_, Site>| {
        let site = *vertex.data();
        site.position
    };
    let ascends = |edge: Directed<'_>| position(edge.from()) < position(edge.to());
    let turns_back = spade.convex_hull().filter(|edge| ascends(*edge) != ascends(edge.next())).count();
    let is_dent = |edge: Directed<'_>| edge.side_query(edge.next().to().position()).is_on_left_side();
    turns_back == 2 && !spade.convex_hull().any(is_dent)
}

/// Inserts sites one by one in rounds, each as large as all rounds before it: drawn at random, then ordered along a
/// curve. Takes near-linear time on every cloud (N. Amenta, S. Choi, G. Rote, "Incremental Constructions con BRIO",
/// SoCG 2003), and about half as long again as bulk loading on a well-spread one.
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

/// Puts sites in a pseudo-random order that is the same every time.
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
    observer: &mut impl Observer,
) -> bool {
    let (appeared, vanished) = hand_on(spade, handles, cloud, change, observer);
    // Insertions come first: the cloud then lies on a line only if it ends on one.
    let mut budget = step_budget(cloud.vertex_count());
    for place in along_curve(appeared.iter().map(|&slot| cloud.position(slot))) {
        let slot = appeared[place];
        let site = Site { position: cloud.position(slot), slot };
        let inserted = match observer.hint_for(site.position, slot) {
            Some(near) => spade.insert_with_hint(site, vertex_handle(handles, near)),
            None => spade.insert(site),
        };
        let handle = inserted.expect("positions are inside the limits, which are spade's");
        handles[slot as usize] = handle.index() as u32;
        let degree = observer.on_inserted(HalfEdges(spade), out_of(spade, handle));
        budget -= insertion_cost(degree);
        if budget < 0.0 {
            return false;
        }
    }
    for place in along_curve(vanished.iter().map(|&slot| cloud.position(slot))) {
        let slot = vanished[place];
        let handle = vertex_handle(handles, slot);
        let degree = observer.before_removal(HalfEdges(spade), out_of(spade, handle));
        // Before it is begun: one removal can take longer than everything else.
        budget -= removal_cost(degree);
        if budget < 0.0 {
            return false;
        }
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

/// Hands the site of a position that was left and taken again between two changes over to its new slot. Returns the
/// slots whose sites really have to be inserted and removed.
fn hand_on(
    spade: &mut Spade,
    handles: &mut [u32],
    cloud: &Cloud,
    change: &CloudChange,
    observer: &mut impl Observer,
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
        observer.before_removal(HalfEdges(spade), out_of(spade, handle));
        spade.vertex_data_mut(handle).slot = slot;
        observer.on_inserted(HalfEdges(spade), out_of(spade, handle));
        false
    });
    (appeared, vanished)
}

fn remove(spade: &mut Spade, handles: &mut [u32], handle: FixedVertexHandle) {
    spade.remove(handle);
    // `spade` moves its last vertex into the gap.
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
        // Both directions of an edge are adjacent in memory, and nothing else is read.
        let (there, back) = (edge.as_directed(), edge.as_directed().rev());
        mesh.push_edge(MeshEdge {
            ends: [there.from(), back.from()].map(|vertex| vertex.index() as u32),
            faces: [there.face(), back.face()].map(|face| face.index() as u32),
        });
    }
}
