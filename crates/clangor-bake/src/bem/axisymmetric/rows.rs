//! A row of the system: the integral equation at one node.
//!
//! ```text
//! ½ p_m(x) − Σ_panels ∫ D_m p_m r' ds' = ∫ S_m a_m r' ds'
//! ```
//!
//! A panel far from the target is integrated at its own nodes. A near panel is halved towards the target
//! until each part is far, with the pressure interpolated. Far means that the target and its image behind the
//! axis lie outside the ellipse around the part on which Gauss' rule has converged. On the target's own panel
//! the kernels are singular like ln|s − s'|: each side has a Gauss rule in the cube root of the distance,
//! which turns the integrand into a function with four derivatives.

use glam::DVec2;
use num_complex::Complex64;

use super::lanes::{LANES, Lanes};
use super::panels::{Node, Panels};
use super::ring::{MidpointLadder, RingRule, Sources};

/// Accuracy of the rule on a far panel, and on a part of a near one.
const FAR: f64 = 1e-13;
const NEAR: f64 = 1e-10;

/// A field to solve for: its wavenumber and azimuthal orders.
#[derive(Clone, Debug)]
pub(super) struct Wave<const M: usize> {
    /// k [1/m].
    pub(super) wavenumber: Complex64,
    /// m.
    pub(super) orders: [usize; M],
    /// Right-hand sides of each order: indices into the accelerations of the context.
    pub(super) sources: [Vec<usize>; M],
}

/// Collocation points of the equation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observer {
    /// (r, y) \[m\], off the axis.
    position: DVec2,
    /// Panel and parameter of a node; `None` for a point inside the body.
    home: Option<(usize, f64)>,
}

impl Observer {
    /// A collocation point.
    pub(super) fn node(node: &Node) -> Self {
        Observer { position: node.position, home: Some((node.panel, node.t)) }
    }

    /// A point inside, where the pressure must vanish.
    pub(super) fn inside(position: DVec2) -> Self {
        Observer { position, home: None }
    }
}

/// Data shared by all rows.
pub(super) struct RowContext<'a, const M: usize> {
    panels: &'a Panels,
    ladder: &'a MidpointLadder,
    waves: &'a [Wave<M>],
    /// Normal accelerations at the nodes.
    accelerations: &'a [Vec<f64>],
    /// Highest Re k [1/m] and m.
    highest: (f64, usize),
    /// Points and weights on [0, 1] of the rule for ln x, on each side of the target.
    singular: Vec<(f64, f64)>,
    /// (d₁ + d₂)/length above which a panel is far.
    far: f64,
    /// The same for a part of a panel.
    near: f64,
}

/// One row for every wave.
pub(super) struct Row {
    /// Real parts of ∫ D_m: wave, order, column.
    pub(super) real: Vec<f64>,
    /// Imaginary parts.
    pub(super) imaginary: Vec<f64>,
    /// Right-hand sides of each wave, order after order.
    pub(super) rhs: Vec<Vec<Complex64>>,
}

impl<'a, const M: usize> RowContext<'a, M> {
    pub(super) fn new(
        panels: &'a Panels,
        ladder: &'a MidpointLadder,
        waves: &'a [Wave<M>],
        accelerations: &'a [Vec<f64>],
    ) -> Self {
        let order = panels.rule.len();
        // Gauss' rule with n points has an error of ρ^{−2n} if the integrand is analytic within the ellipse
        // of parameter ρ around the panel. A point lies on that ellipse if its distances from the ends sum to
        // (ρ + 1/ρ)/2 lengths.
        let ratio = |accuracy: f64| {
            let rho = accuracy.powf(-0.5 / order as f64);
            0.5 * (rho + 1.0 / rho)
        };
        let singular = crate::quadrature::gauss_legendre(order + 8)
            .into_iter()
            .map(|(x, w)| (x * x * x, 3.0 * x * x * w))
            .collect();
        let highest = (
            waves.iter().map(|w| w.wavenumber.re).fold(0.0, f64::max),
            waves.iter().flat_map(|w| w.orders).max().unwrap_or(0),
        );
        RowContext {
            panels,
            ladder,
            waves,
            accelerations,
            highest,
            singular,
            far: ratio(FAR),
            near: ratio(NEAR),
        }
    }

    /// The row of an observer.
    pub(super) fn row(&self, observer: Observer) -> Row {
        pulp::Arch::new().dispatch(RowTask { context: self, observer })
    }

    #[inline(always)]
    fn row_inlined<const DAMPED: bool>(&self, observer: Observer) -> Row {
        let panels = self.panels;
        let count = panels.rule.len();
        let width = panels.nodes.len() * M * self.waves.len();
        let rhs = |wave: &Wave<M>| vec![Complex64::ZERO; wave.sources.iter().map(Vec::len).sum()];
        let mut row = RowBuilder {
            row: Row {
                real: vec![0.0; width],
                imaginary: vec![0.0; width],
                rhs: self.waves.iter().map(rhs).collect(),
            },
            rule: RingRule::default(),
            cardinal: vec![0.0; LANES * count],
            accelerations: vec![Lanes::default(); self.accelerations.len()],
            column: 0,
        };
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (index, panel) in panels.panels.iter().enumerate() {
            row.column = index * count;
            let at_home = observer.home.is_some_and(|(home, _)| home == index);
            // Far panel: its own nodes.
            if !at_home && separated(observer.position, panel.from, panel.to, panel.length, self.far) {
                for first in (0..count).step_by(LANES) {
                    let group = &panels.nodes[row.column + first..row.column + first + LANES];
                    let ring = Group::of(|l| {
                        let Node { position, normal, weight, .. } = group[l];
                        let chord = position - observer.position;
                        let (gap_square, across) = (chord.length_squared(), chord.dot(normal));
                        Point { position, normal, weight, gap_square, across }
                    });
                    row.add::<DAMPED, M>(self, observer, &ring, Target::Columns(first));
                }
                continue;
            }
            // Parameter offsets from the target if it is on this piece, otherwise the parameter itself.
            let same_piece =
                observer.home.filter(|(home, _)| panels.panels[*home].piece == panel.piece).map(|(_, t)| t);
            let origin = same_piece.unwrap_or(0.0);
            points.clear();
            // Own panel: singular rule on each side of the target. Near panel: graded subdivision.
            if at_home {
                for reach in [panel.start - origin, panel.end - origin] {
                    points.extend(self.singular.iter().map(|(x, w)| (reach * x, (reach * w).abs())));
                }
            } else {
                self.near_points(observer.position, index, origin, &mut points);
            }
            let piece = panels.pieces[panel.piece];
            let span = panel.end - panel.start;
            // Kernels at the quadrature points, eight at a time.
            for group in points.chunks_exact(LANES) {
                let ring = Group::of(|l| {
                    let (step, weight) = group[l];
                    let t = origin + step;
                    let v = piece.velocity(t);
                    let normal = DVec2::new(v.y, -v.x);
                    let position = piece.point(t);
                    let (chord, across) = match same_piece {
                        Some(own) => piece.chord(own, step),
                        None => {
                            let chord = position - observer.position;
                            (chord, chord.dot(normal))
                        }
                    };
                    Point { position, normal, weight, gap_square: chord.length_squared(), across }
                });
                // Interpolation from the panel's nodes to the points.
                for (l, (step, _)) in group.iter().enumerate() {
                    let x = (origin - panel.start + step) / span;
                    panels.cardinal(x, &mut row.cardinal[l * count..(l + 1) * count]);
                }
                row.add::<DAMPED, M>(self, observer, &ring, Target::Interpolated);
            }
        }
        row.row
    }

    /// Quadrature points of a panel near a target, halved towards it; parameters relative to `origin`.
    #[inline(always)]
    fn near_points(&self, position: DVec2, index: usize, origin: f64, points: &mut Vec<(f64, f64)>) {
        let panel = &self.panels.panels[index];
        let piece = &self.panels.pieces[panel.piece];
        let mut stack = vec![(panel.start, panel.end, 0)];
        while let Some((start, end, depth)) = stack.pop() {
            let middle = 0.5 * (start + end);
            let (from, centre, to) = (piece.point(start), piece.point(middle), piece.point(end));
            let length = from.distance(centre) + centre.distance(to);
            // A node is at least 1/200 of the smallest adjacent panel away, so the depth limit is never
            // reached.
            if depth < 40 && !separated(position, from, to, length, self.near) {
                stack.push((middle, end, depth + 1));
                stack.push((start, middle, depth + 1));
                continue;
            }
            let span = end - start;
            points.extend(self.panels.rule.iter().map(|(x, w)| (start - origin + span * x, span * w)));
        }
    }
}

/// Whether a target and its image behind the axis lie outside the ellipse around an interval of the meridian.
#[inline(always)]
fn separated(position: DVec2, from: DVec2, to: DVec2, length: f64, ratio: f64) -> bool {
    let image = DVec2::new(-position.x, position.y);
    [position, image].iter().all(|p| p.distance(from) + p.distance(to) >= ratio * length)
}

/// A row in the form that `pulp` compiles for each instruction set.
struct RowTask<'a, const M: usize> {
    context: &'a RowContext<'a, M>,
    observer: Observer,
}

impl<const M: usize> pulp::WithSimd for RowTask<'_, M> {
    type Output = Row;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Row {
        // Single orders are solved at real frequencies only, so no damped code is generated for them.
        if M == 1 || self.context.waves.iter().all(|w| w.wavenumber.im == 0.0) {
            self.context.row_inlined::<false>(self.observer)
        } else {
            self.context.row_inlined::<true>(self.observer)
        }
    }
}

/// Destination of the kernels of eight points.
#[derive(Clone, Copy)]
enum Target {
    /// To the columns of eight nodes, from this one of the panel.
    Columns(usize),
    /// To all nodes of the panel, through the cardinal polynomials.
    Interpolated,
}

/// A point of a quadrature on the meridian.
struct Point {
    position: DVec2,
    normal: DVec2,
    weight: f64,
    gap_square: f64,
    across: f64,
}

/// Eight points in lanes.
struct Group {
    sources: Sources,
    /// Speed of the parameter \[m\].
    speed: Lanes,
    widest: f64,
}

impl Group {
    #[inline(always)]
    fn of(point: impl Fn(usize) -> Point) -> Self {
        let mut group = Group { sources: Sources::default(), speed: Lanes::default(), widest: 0.0 };
        for l in 0..LANES {
            let p = point(l);
            group.sources.radius.0[l] = p.position.x;
            group.sources.gap_square.0[l] = p.gap_square;
            group.sources.normal_r.0[l] = p.normal.x;
            group.sources.across.0[l] = p.across;
            group.sources.weight.0[l] = p.weight;
            group.speed.0[l] = p.normal.length();
            group.widest = group.widest.max(p.position.x);
        }
        group
    }
}

/// A row during assembly.
struct RowBuilder {
    row: Row,
    rule: RingRule,
    /// Cardinal polynomials at eight points.
    cardinal: Vec<f64>,
    /// Accelerations at eight points, times the speed of the parameter.
    accelerations: Vec<Lanes>,
    /// First column of the panel.
    column: usize,
}

impl RowBuilder {
    #[inline(always)]
    fn add<const DAMPED: bool, const M: usize>(
        &mut self,
        context: &RowContext<M>,
        observer: Observer,
        group: &Group,
        target: Target,
    ) {
        // Quadrature around the axis for the eight rings.
        let r = observer.position.x;
        let (wavenumber, order) = context.highest;
        let midpoints = context.ladder.rule(wavenumber * r.min(group.widest), order);
        self.rule.prepare(r, &group.sources, midpoints);
        let nodes = context.panels.nodes.len();
        let count = context.panels.rule.len();
        // Normal accelerations at the eight points.
        for (lanes, values) in self.accelerations.iter_mut().zip(context.accelerations) {
            let values = &values[self.column..self.column + count];
            *lanes = match target {
                Target::Columns(first) => Lanes::from_fn(|l| values[first + l]),
                Target::Interpolated => Lanes::from_fn(|l| {
                    let cardinal = &self.cardinal[l * count..(l + 1) * count];
                    cardinal.iter().zip(values).map(|(c, a)| c * a).sum()
                }),
            } * group.speed;
        }
        for (f, wave) in context.waves.iter().enumerate() {
            // Ring kernels of the wave.
            let kernels = self.rule.kernels::<DAMPED, M>(wave.wavenumber, wave.orders, midpoints);
            let mut rhs = self.row.rhs[f].iter_mut();
            // Single layer: right-hand sides.
            for ([re, im], sources) in kernels.single.iter().zip(&wave.sources) {
                for (source, sum) in sources.iter().zip(&mut rhs) {
                    let acceleration = &self.accelerations[*source];
                    for l in 0..LANES {
                        *sum += Complex64::new(re.0[l], im.0[l]) * acceleration.0[l];
                    }
                }
            }
            // Double layer: matrix entries.
            for (m, [re, im]) in kernels.double.iter().enumerate() {
                let start = (M * f + m) * nodes + self.column;
                match target {
                    Target::Columns(first) => {
                        for l in 0..LANES {
                            self.row.real[start + first + l] += re.0[l];
                            self.row.imaginary[start + first + l] += im.0[l];
                        }
                    }
                    Target::Interpolated => {
                        let real = &mut self.row.real[start..start + count];
                        let imaginary = &mut self.row.imaginary[start..start + count];
                        for l in 0..LANES {
                            let cardinal = &self.cardinal[l * count..(l + 1) * count];
                            for ((real, imaginary), c) in
                                real.iter_mut().zip(imaginary.iter_mut()).zip(cardinal)
                            {
                                *real = c.mul_add(re.0[l], *real);
                                *imaginary = c.mul_add(im.0[l], *imaginary);
                            }
                        }
                    }
                }
            }
        }
    }
}
