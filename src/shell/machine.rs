//! What the machine has to give.

use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Bytes of memory that are free, if the system tells.
pub(crate) fn free_memory() -> Option<u64> {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::everything());
    let system = System::new_with_specifics(memory).ok()?;
    let free = system.available_memory().saturating_add(system.free_swap());
    let allowed = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
    Some(free.min(allowed)).filter(|bytes| *bytes > 0)
}

/// Bytes as people say them.
pub(crate) fn giga(bytes: u64) -> String {
    format!("{:.1} GB", bytes as f64 / 1e9)
}
