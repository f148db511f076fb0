//! The threads that work side by side on one call.
//!
//! A pool of our own instead of rayon's global one: a process that was forked (Python's `multiprocessing` on Linux) has its
//! parent's memory and none of its threads, and would wait for them for ever.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The pool and the process that it belongs to.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process: as many threads as there are processors, or as RAYON_NUM_THREADS says.
///
/// Called with the interpreter held, so that no other thread can fork meanwhile.
pub fn pool(_py: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    let mut slot = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = &*slot {
        if *owner == process {
            return Ok(Arc::clone(pool));
        }
    }
    let made = ThreadPoolBuilder::new().thread_name(|i| format!("smooth_polylines-{i}")).build();
    let pool = Arc::new(made.map_err(|error| PyOSError::new_err(format!("cannot start threads: {error}")))?);
    // Dropping the parent's pool would wait for its threads.
    std::mem::forget(slot.replace((process, Arc::clone(&pool))));
    Ok(pool)
}
