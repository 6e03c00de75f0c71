//! Processor time [s], of one thread, of the steps of a Galerkin solution on a sphere:
//! `cargo bench -p clangor-bake --bench triangles`.

use std::time::Instant;

use clangor_bake::bem::triangles::{Equation, TriangleSolver};
use clangor_bake::radiation::RadiationSolver;
use clangor_core::shape::Shape;

/// Number of runs; the fastest counts.
const RUNS: usize = 3;

fn main() {
    println!("  N    near, all k   assembly     LU   solve with multipoles   tables, κ ≤ 6   solve by them");
    for edge in [0.1157, 0.082, 0.058] {
        let mesh = Shape::parse(&format!("sphere:1@{edge}")).expect("a sphere").mesh();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| {
            let k = 3.0;
            let (near, solver) =
                best(|| TriangleSolver::try_new(&mesh, 6.0, Equation::BurtonMiller).expect("small"));
            let (assembly, system) = best(|| solver.assemble(k));
            let (both, _) = best(|| system.clone().solve());
            let (whole, _) = best(|| solver.solve(&[k], 10).expect("finite"));
            // The first solve makes the tables, and the factors near its wavenumber.
            let (first, swept) = best(|| {
                let swept = solver.clone().for_many_wavenumbers(6.0, 3e-4);
                swept.solve(&[k], 10).expect("finite");
                swept
            });
            let (each, _) = best(|| swept.solve(&[k], 10).expect("finite"));
            let [n, tables] = [mesh.vertices.len() as f64, first - each];
            println!("{n:5} {near:10.3} {assembly:12.3} {both:9.3} {whole:12.3} {tables:18.3} {each:14.3}");
        });
    }
}

/// Seconds of the fastest run and its result.
fn best<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = seconds();
        let result = run();
        (seconds() - start, result)
    };
    let first = timed();
    (1..RUNS).map(|_| timed()).fold(first, |a, b| if b.0 < a.0 { b } else { a })
}

/// Processor time of this thread where the system reports it, wall-clock time elsewhere [s].
fn seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    match text.split_whitespace().next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok()) {
        Some(nanoseconds) => nanoseconds * 1e-9,
        None => {
            static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
            START.get_or_init(Instant::now).elapsed().as_secs_f64()
        }
    }
}
