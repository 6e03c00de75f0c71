//! A limit on the work of a computation, by operations that are known only on the way.
//!
//! Each step states its operations before it begins, so that a computation ends before it takes longer than
//! it may. No clock is read: the same body ends at the same step on any machine.

use std::cell::Cell;

use super::operations::PER_SECOND;

/// Operations that may be done, and those that were.
#[derive(Clone, Debug)]
pub(crate) struct WorkLimit {
    most: f64,
    done: Cell<f64>,
}

/// The next step would exceed the limit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("it takes at least {seconds:.0} s of CPU time, more than the {patience:.0} s allowed")]
pub struct TooMuchWork {
    /// CPU time of what was done and of the next step \[s\], estimated.
    pub seconds: f64,
    /// CPU time allowed \[s\].
    pub patience: f64,
}

impl WorkLimit {
    /// A limit of so many seconds of CPU time.
    pub(crate) fn of_seconds(patience: f64) -> Self {
        WorkLimit { most: patience * PER_SECOND, done: Cell::new(0.0) }
    }

    /// No limit.
    pub(crate) fn none() -> Self {
        Self::of_seconds(f64::INFINITY)
    }

    /// Counts the operations of a step that is about to begin.
    ///
    /// # Errors
    /// [`TooMuchWork`] if there are too many of them.
    pub(crate) fn spend(&self, operations: f64) -> Result<(), TooMuchWork> {
        let all = self.done.get() + operations;
        if all > self.most {
            return Err(TooMuchWork { seconds: all / PER_SECOND, patience: self.most / PER_SECOND });
        }
        self.done.set(all);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_before_the_limit() {
        let work = WorkLimit::of_seconds(10.0);
        assert_eq!(work.spend(6.0 * PER_SECOND), Ok(()));
        assert_eq!(work.spend(5.0 * PER_SECOND), Err(TooMuchWork { seconds: 11.0, patience: 10.0 }));
        // A step that was not taken does not count.
        assert_eq!(work.spend(4.0 * PER_SECOND), Ok(()));
        assert_eq!(WorkLimit::none().spend(1e300), Ok(()));
    }
}
