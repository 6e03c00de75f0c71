//! Which models of a scene are drafts: those whose exact bake would take longer than the patience.
//!
//! Work is estimated by [`clangor_bake::cost`], never measured, so that the same scene with the same cache
//! has the same models on any machine. What is in the cache costs nothing. If all exact models together
//! take no longer than the patience, all are exact; else the cheapest are, as many as the patience pays for,
//! and the others are drafts:
//!
//! ```text
//! c₁ ≤ c₂ ≤ …   exact while c₁ + … + cᵢ ≤ patience
//! ```
//!
//! No patience at all makes a draft of everything that is not in the cache.
//!
//! Some estimates are too low: what a surface needs is known exactly where it has been meshed anew. Each
//! exact model may take what the others leave of the patience by their estimates, and is a draft if its mesh
//! needs more.

/// Patience with the exact models of a scene, unless another is asked for: seconds of CPU time.
pub const PATIENCE: f64 = 60.0;

/// CPU time \[s\] that each of the models with these costs may take, `None` for drafts; costs in seconds of
/// CPU time, 0 for those in the cache.
pub(super) fn allowances(costs: &[f64], patience: f64) -> Vec<Option<f64>> {
    let mut cheapest: Vec<usize> = (0..costs.len()).collect();
    cheapest.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]).then(a.cmp(b)));
    let mut exact = vec![false; costs.len()];
    let mut spent = 0.0;
    for at in cheapest {
        exact[at] = spent + costs[at] <= patience;
        spent += if exact[at] { costs[at] } else { 0.0 };
    }
    let left = patience - spent;
    exact.iter().zip(costs).map(|(exact, cost)| exact.then_some(left + cost)).collect()
}

/// An estimated time in words, of one or two digits.
pub fn cpu_time(seconds: f64) -> String {
    match seconds {
        s if s < 0.95 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_are_exact_as_far_as_patience_goes() {
        let costs = [30.0, 0.0, 50.0, 20.0];
        assert_eq!(allowances(&costs, 100.0), [30.0, 0.0, 50.0, 20.0].map(Some));
        assert_eq!(allowances(&costs, 60.0), [Some(40.0), Some(10.0), None, Some(30.0)]);
        assert_eq!(allowances(&costs, 25.0), [None, Some(5.0), None, Some(25.0)]);
        assert_eq!(allowances(&costs, 0.0), [None, Some(0.0), None, None]);
        assert_eq!(allowances(&costs, f64::INFINITY), [Some(f64::INFINITY); 4]);
    }
}
