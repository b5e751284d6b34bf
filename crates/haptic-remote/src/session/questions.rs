//! Questions of the host, and their answers.

use super::{DeviceSession, ack};
use crate::hardware::{Exclusive, Hardware};
use crate::records::Records;
use crate::tick_side::TickSide;
use core::borrow::BorrowMut;
use haptic_link::{
    Alive, COEFFICIENTS_PER_BLOCK, CoefficientBlock, Field, Header, Keys, Refusal, Report, Request,
    Statistics,
};

impl DeviceSession {
    /// The answer to a question; nothing if it is an order. On its own: an order needs the stack for other things.
    #[inline(never)]
    pub(super) fn answer<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>>(
        &self,
        header: Header,
        request: &Request,
        now_us: u64,
        device: &impl Exclusive<TickSide<H, D, R>>,
    ) -> Option<Report> {
        let refused = |refusal| ack(header, request.number(), Err(refusal));
        Some(match *request {
            Request::GetKeys => keys(),
            Request::GetCapabilities => {
                Report::Capabilities(device.with(|device| device.hardware().capabilities()))
            }
            Request::GetConfiguration => device.with(|device| {
                let (configuration, digest) = device.configuration();
                Report::Configuration {
                    configuration: *configuration,
                    digest,
                }
            }),
            Request::KeepAlive { token } => device.with(|device| {
                Report::Alive(Alive {
                    token,
                    time_us: now_us,
                    status: device.status(),
                    observed_energy_j: device.observed_energy_j(),
                })
            }),
            Request::GetStatistics => {
                let ticks = device.with(|device| *device.statistics());
                Report::Statistics(self.statistics(ticks))
            }
            Request::GetCoefficients { offset } => device
                .with(|device| coefficients(device, offset))
                .map_or_else(refused, Report::Coefficients),
            Request::ReadFlight { index } => device
                .with(|device| device.flight(index))
                .unwrap_or_else(refused),
            _ => return None,
        })
    }

    fn statistics(&self, ticks: Statistics) -> Statistics {
        let line = self.receiver.counters();
        let requests = self.connections.tracker().out_of_order();
        Statistics {
            sent: self.sent,
            received: line.received,
            corrupt: line.corrupt,
            oversize: line.oversize,
            foreign: line.foreign,
            lost: requests.lost,
            duplicate: requests.duplicate,
            late: requests.late,
            bytes_overrun: self.bytes_overrun,
            strangers: self.connections.strangers(),
            ..ticks
        }
    }
}

/// The keys of all messages.
#[inline(never)]
fn keys() -> Report {
    Report::Keys(Keys::current())
}

/// The block of coefficients in force at an offset.
fn coefficients<H: Hardware<D>, const D: usize, R: BorrowMut<Records<D>>>(
    device: &TickSide<H, D, R>,
    offset: u16,
) -> Result<CoefficientBlock, Refusal> {
    let count = device.configuration().0.operator.count;
    if offset >= count || !offset.is_multiple_of(COEFFICIENTS_PER_BLOCK as u16) {
        return Err(Refusal::Range {
            field: Field::Offset,
            value: f32::from(offset),
            least: 0.0,
            most: f32::from(count.saturating_sub(1)),
        });
    }
    let values = core::array::from_fn(|i| {
        device
            .coefficient(usize::from(offset) + i)
            .unwrap_or_default()
    });
    Ok(CoefficientBlock { offset, values })
}
