//! The planar part of holes, for the rooms that do not know the plane.
//!
//! In: dots and detections, the triangulation.
//! Out: holes with their centres, and regions.
//! Invariant: the centre of a hole is the circumcentre of the triangle that names the death.
//! Must not know: views, events.

use crate::topology::cloud::{Cloud, Position, Slot};
use crate::topology::plane::delaunay::Delaunay;
use crate::topology::plane::geometry::circumcircle;
use crate::topology::plane::holes::{Region, RegionCache, boundary};
use crate::topology::skeleton::{Dot, Filtration, Hole, Killer, Skeleton};
use crate::topology::tracks::{Detection, HoleRegion};

impl Skeleton {
    /// The hole of a dot in the plane: circumcentre and circumradius of the triangle whose filling kills it.
    pub fn hole(&self, dot: &Dot) -> Option<Hole> {
        let (Filtration::Alpha, Killer::Triangle(triangle)) = (self.filtration(), dot.killer) else { return None };
        let circle = circumcircle(triangle.map(|vertex| Position::of_vertex(self.vertices().xy(vertex))));
        Some(Hole { center: circle.center, radius: dot.death })
    }
}

/// The hole of a dot by slots.
pub(super) fn hole(cloud: &Cloud, triangle: [Slot; 3], death: f64) -> Hole {
    Hole { center: circumcircle(triangle.map(|slot| cloud.position(slot))).center, radius: death }
}

impl HoleRegion for Region {
    fn is_unknown(&self) -> bool {
        self.boundary().is_empty()
    }

    fn vertex_count(&self) -> usize {
        self.boundary().iter().map(Vec::len).sum()
    }

    fn area(&self) -> f64 {
        self.area()
    }

    fn contains(&self, point: [f64; 2]) -> bool {
        self.contains(point)
    }

    fn is_near(&self, point: [f64; 2]) -> bool {
        self.is_near(point)
    }
}

/// The region of a detection's hole, from the cache if it is there.
pub(super) fn cached_region(
    regions: &mut RegionCache,
    cloud: &Cloud,
    delaunay: &Delaunay,
    detection: &Detection,
) -> Region {
    regions.get((detection.triangle, detection.critical.edge), || find_region(cloud, delaunay, detection))
}

/// The region of a hole; none if the triangulation has no such dot.
fn find_region(cloud: &Cloud, delaunay: &Delaunay, detection: &Detection) -> Option<Region> {
    let walks = boundary(delaunay, detection.name, detection.edge)?;
    Some(Region::new(walks, |slot| cloud.id(slot)))
}
