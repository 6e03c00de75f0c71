//! Division of the body in a cell between walls that meet there, each with displacements of its own.
//!
//! Each wall has a depth below its faces, and a point belongs to the wall in which it is deepest. At an inner
//! edge the two are divided by the plane that halves its angle (a mitre); across a slit by the middle plane
//! of the void, where nothing is left to divide. Depths are linear in tetrahedra of a regular grid in the
//! cell (six per cube, the same on both sides of a face), so that divisions are plane in each, and
//! neighbouring cells divide their common face alike.

use glam::DVec3;

use super::chain::{Chain, Origin, Plane, plane_across};

/// Cubes along the edge of a cell.
pub(super) const CUBES: usize = 4;
const POINTS: usize = CUBES + 1;

/// The depths of the walls of a cell.
#[derive(Clone, Debug)]
pub(super) struct Division {
    /// Depth below each wall at each point of the grid, by x, y, z; in units of cells.
    depths: Vec<Vec<f64>>,
}

/// A triangle of a division: corners, and its area, negative where it faces backwards.
pub(super) struct Divided {
    pub(super) walls: [usize; 2],
    pub(super) corners: [DVec3; 3],
    /// Twice its area.
    pub(super) area: f64,
}

/// A tetrahedron of a cube: order of its axes, and depths of the walls at its corners.
struct Tetrahedron {
    axes: [usize; 3],
    low: [usize; 3],
}

impl Division {
    /// From the depth below a wall at a point, in units of cells from the corner of the cell.
    pub(super) fn new(walls: usize, depth: impl Fn(usize, DVec3) -> f64) -> Self {
        let point = |k: usize| {
            let at = [k / (POINTS * POINTS), k / POINTS % POINTS, k % POINTS];
            DVec3::from_array(at.map(|n| n as f64 / CUBES as f64))
        };
        let depths = (0..walls).map(|wall| (0..POINTS.pow(3)).map(|k| depth(wall, point(k))).collect());
        Division { depths: depths.collect() }
    }

    pub(super) fn walls(&self) -> usize {
        self.depths.len()
    }

    fn at(&self, wall: usize, point: [usize; 3]) -> f64 {
        self.depths[wall][(point[0] * POINTS + point[1]) * POINTS + point[2]]
    }

    fn deepest(&self, point: [usize; 3]) -> usize {
        (1..self.walls())
            .fold(0, |best, wall| if self.at(wall, point) > self.at(best, point) { wall } else { best })
    }

    /// Linear depth in a tetrahedron of a cube.
    fn linear(&self, wall: usize, tetrahedron: &Tetrahedron) -> (f64, DVec3) {
        let mut corner = tetrahedron.low;
        let first = self.at(wall, corner);
        let (mut before, mut slope) = (first, DVec3::ZERO);
        for axis in tetrahedron.axes {
            corner[axis] += 1;
            let depth = self.at(wall, corner);
            slope[axis] = (depth - before) * CUBES as f64;
            before = depth;
        }
        let low = DVec3::from_array(tetrahedron.low.map(|n| n as f64 / CUBES as f64));
        (first - slope.dot(low), slope)
    }

    /// The wall of a point of the cell.
    pub(super) fn wall_at(&self, at: DVec3) -> usize {
        let scaled = (at * CUBES as f64).clamp(DVec3::ZERO, DVec3::splat(CUBES as f64));
        let low = scaled.to_array().map(|x| (x as usize).min(CUBES - 1));
        let inside = scaled - DVec3::from_array(low.map(|n| n as f64));
        let mut axes = [0, 1, 2];
        axes.sort_by(|a, b| inside[*b].total_cmp(&inside[*a]));
        let tetrahedron = Tetrahedron { axes, low };
        let depth = |wall: usize| {
            let (constant, slope) = self.linear(wall, &tetrahedron);
            constant + slope.dot(at)
        };
        (1..self.walls()).fold(0, |best, wall| if depth(wall) > depth(best) { wall } else { best })
    }

    /// The part of a chain in each wall, and the triangles of the divisions, each once.
    pub(super) fn parts(&self, chain: &Chain) -> (Vec<Chain>, Vec<Divided>) {
        let mut parts = vec![Chain::default(); self.walls()];
        let mut divided = Vec::new();
        self.divide(chain, [0; 3], [CUBES; 3], &mut parts, &mut divided);
        (parts, divided)
    }

    /// Halves a box of cubes until it lies in one wall or is a cube.
    fn divide(
        &self,
        chain: &Chain,
        low: [usize; 3],
        high: [usize; 3],
        parts: &mut [Chain],
        divided: &mut Vec<Divided>,
    ) {
        if chain.is_empty() {
            return;
        }
        let wall = self.deepest(low);
        // Depths are linear in between.
        let mut points = (low[0]..=high[0])
            .flat_map(|x| (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z])));
        if points.all(|point| self.deepest(point) == wall) {
            parts[wall].extend(chain.clone());
            return;
        }
        let axis = (1..3).fold(0, |a, b| if high[b] - low[b] > high[a] - low[a] { b } else { a });
        let middle = (low[axis] + high[axis]) / 2;
        if middle == low[axis] {
            return self.divide_cube(chain, low, parts, divided);
        }
        let plane = plane_across(axis, middle as f64 / CUBES as f64);
        let (mut below, mut above) = (high, low);
        below[axis] = middle;
        above[axis] = middle;
        self.divide(&chain.cut(&plane, false, Origin::Inner), low, below, parts, divided);
        self.divide(&chain.cut(&plane, true, Origin::Inner), above, high, parts, divided);
    }

    /// Divides a chain in one cube: by the planes of its six tetrahedra, then by the planes between walls.
    fn divide_cube(&self, chain: &Chain, low: [usize; 3], parts: &mut [Chain], divided: &mut Vec<Divided>) {
        let corner = DVec3::from_array(low.map(|n| n as f64 / CUBES as f64));
        let diagonal = |a: usize, b: usize| Plane {
            value: move |x: DVec3| (x[a] - corner[a]) - (x[b] - corner[b]),
            across: None,
        };
        let planes = [diagonal(0, 1), diagonal(1, 2), diagonal(0, 2)];
        let side = |chain: &Chain, k: usize, above: bool| chain.cut(&planes[k], above, Origin::Inner);
        let mut in_tetrahedron = |axes: [usize; 3], chain: &Chain| {
            self.divide_tetrahedron(chain, &Tetrahedron { axes, low }, parts, divided);
        };
        for first in [true, false] {
            let half = side(chain, 0, first);
            for second in [true, false] {
                let quarter = side(&half, 1, second);
                match (first, second) {
                    (true, true) => in_tetrahedron([0, 1, 2], &quarter),
                    (false, false) => in_tetrahedron([2, 1, 0], &quarter),
                    (true, false) => {
                        in_tetrahedron([0, 2, 1], &side(&quarter, 2, true));
                        in_tetrahedron([2, 0, 1], &side(&quarter, 2, false));
                    }
                    (false, true) => {
                        in_tetrahedron([1, 0, 2], &side(&quarter, 2, true));
                        in_tetrahedron([1, 2, 0], &side(&quarter, 2, false));
                    }
                }
            }
        }
    }

    fn divide_tetrahedron(
        &self,
        chain: &Chain,
        tetrahedron: &Tetrahedron,
        parts: &mut [Chain],
        divided: &mut Vec<Divided>,
    ) {
        if chain.is_empty() {
            return;
        }
        let depths: Vec<(f64, DVec3)> =
            (0..self.walls()).map(|wall| self.linear(wall, tetrahedron)).collect();
        let mut points = vec![tetrahedron.low];
        for axis in tetrahedron.axes {
            let mut next = points[points.len() - 1];
            next[axis] += 1;
            points.push(next);
        }
        let never = |wall: &usize| {
            (0..self.walls()).any(|other| points.iter().all(|p| self.at(other, *p) > self.at(*wall, *p)))
        };
        let walls: Vec<usize> = (0..self.walls()).filter(|wall| !never(wall)).collect();
        for &wall in &walls {
            let mut own = chain.clone();
            for &other in walls.iter().filter(|other| **other != wall) {
                let (first, second) = (wall.min(other), wall.max(other));
                let constant = depths[first].0 - depths[second].0;
                let slope = depths[first].1 - depths[second].1;
                let plane = Plane { value: move |x: DVec3| constant + slope.dot(x), across: None };
                own = own.cut(&plane, wall < other, Origin::Division(other));
            }
            for cap in &own.caps {
                let Origin::Division(other) = cap.origin else { continue };
                if other > wall {
                    // Outwards, the depth below the wall falls against that below the other.
                    let outward = (depths[other].1 - depths[wall].1).normalize_or_zero();
                    divided.extend(cap.cones().map(|corners| {
                        let [a, b, c] = corners;
                        let vector = (b - a).cross(c - a);
                        let area = vector.length().copysign(vector.dot(outward));
                        Divided { walls: [wall, other], corners, area }
                    }));
                }
            }
            parts[wall].extend(own);
        }
    }
}
