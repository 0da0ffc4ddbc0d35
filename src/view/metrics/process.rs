//! Metrics of the process, under the names that Prometheus' own clients use.
//!
//! In: `/proc`, which only Linux has.
//! Out: metrics. One that cannot be read is left out.
//! Invariants: none beyond that.
//! Must not know: the daemon.

use std::fmt;

use procfs::ProcResult;
use procfs::process::{LimitValue, Process};
use prometheus_client::encoding::DescriptorEncoder;
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::registry::Unit;

use super::{encode_counter, encode_gauge};

/// What the metrics tell.
struct Usage {
    cpu_seconds: f64,
    resident: u64,
    virtual_memory: u64,
    open_fds: u64,
    /// None if there is no limit.
    max_fds: Option<u64>,
    /// Since the Unix epoch.
    start_seconds: f64,
    threads: u64,
}

impl Usage {
    fn read() -> ProcResult<Self> {
        let process = Process::myself()?;
        let stat = process.stat()?;
        let seconds = |ticks: u64| ticks as f64 / procfs::ticks_per_second() as f64;
        let max_fds = match process.limits()?.max_open_files.soft_limit {
            LimitValue::Unlimited => None,
            LimitValue::Value(limit) => Some(limit),
        };
        Ok(Self {
            cpu_seconds: seconds(stat.utime + stat.stime),
            resident: stat.rss * procfs::page_size(),
            virtual_memory: stat.vsize,
            open_fds: process.fd_count()? as u64,
            max_fds,
            start_seconds: procfs::boot_time_secs()? as f64 + seconds(stat.starttime),
            threads: stat.num_threads.unsigned_abs(),
        })
    }
}

/// Encodes the metrics of this process.
pub fn encode(encoder: &mut DescriptorEncoder) -> fmt::Result {
    let Ok(usage) = Usage::read() else { return Ok(()) };
    let (seconds, bytes) = (Some(&Unit::Seconds), Some(&Unit::Bytes));
    let help = "Processor time of the process, of user and system.";
    encode_counter(encoder, "process_cpu", help, seconds, ConstCounter::new(usage.cpu_seconds))?;
    encode_gauge(encoder, "process_resident_memory", "Resident memory.", bytes, usage.resident)?;
    encode_gauge(encoder, "process_virtual_memory", "Virtual memory.", bytes, usage.virtual_memory)?;
    encode_gauge(encoder, "process_open_fds", "Open file descriptors.", None, usage.open_fds)?;
    if let Some(max_fds) = usage.max_fds {
        encode_gauge(encoder, "process_max_fds", "File descriptors at the most.", None, max_fds)?;
    }
    let help = "Start of the process, since the Unix epoch.";
    encode_gauge(encoder, "process_start_time", help, seconds, usage.start_seconds)?;
    encode_gauge(encoder, "process_threads", "Threads of the process.", None, usage.threads)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_is_plausible() {
        let usage = Usage::read().unwrap();
        assert!(usage.cpu_seconds >= 0.0 && usage.open_fds > 2 && usage.threads > 0);
        assert!(0 < usage.resident && usage.resident <= usage.virtual_memory);
        assert!(usage.max_fds.is_none_or(|most| most >= usage.open_fds));
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
        let age = now - usage.start_seconds;
        assert!((-5.0..86_400.0).contains(&age), "started {age} s ago");
    }
}
