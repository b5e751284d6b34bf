//! One key for each message: a hash of its definition. A host compares those of the messages that it uses.

#[cfg(feature = "controllers")]
use crate::request::CONTROLLER_REQUESTS;
use crate::{
    report::{COMMON_REPORTS, DeviceReport, KEYS_MAX, Keys, MessageKey, REPORTS},
    request::{AXES_REQUESTS, ONE_AXIS_REQUESTS, REQUESTS, Request},
};
use core::ops::Range;
use postcard_schema::{
    Schema,
    key::Key,
    schema::{DataModelType, NamedType, NamedVariant},
};

/// Keys of the requests in this version of the crate.
#[cfg(not(feature = "controllers"))]
pub const REQUEST_KEYS: [MessageKey; REQUESTS] =
    keys!(RequestVariant: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16);
/// Keys of the requests in this version of the crate.
#[cfg(all(feature = "controllers", not(feature = "several-axes")))]
pub const REQUEST_KEYS: [MessageKey; REQUESTS] =
    keys!(RequestVariant: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19);
/// Keys of the requests in this version of the crate.
#[cfg(feature = "several-axes")]
pub const REQUEST_KEYS: [MessageKey; REQUESTS] =
    keys!(RequestVariant: 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20);
/// Keys of the reports in this version of the crate.
#[cfg(not(feature = "controllers"))]
pub const REPORT_KEYS: [MessageKey; REPORTS] = keys!(ReportVariant: 0 1 2 3 4 5 6 7 8 9 10 11 12);
/// Keys of the reports in this version of the crate.
#[cfg(feature = "controllers")]
pub const REPORT_KEYS: [MessageKey; REPORTS] =
    keys!(ReportVariant: 0 1 2 3 4 5 6 7 8 9 10 11 12 13);

impl Keys {
    /// The keys of the messages in this version of the crate.
    #[must_use]
    pub fn current() -> Self {
        // There is room for all, see below.
        Self {
            requests: REQUEST_KEYS.into_iter().collect(),
            reports: REPORT_KEYS.into_iter().collect(),
        }
    }

    /// Name of the first message, for a device with this many axes, that the other end lacks or
    /// defines differently. Extra messages do no harm.
    #[must_use]
    pub fn first_unlike(&self, axes: u8) -> Option<&'static str> {
        let requests = match axes {
            0 | 1 => ONE_AXIS_REQUESTS,
            _ => AXES_REQUESTS.min(REQUESTS),
        };
        let request = unlike(&self.requests, &REQUEST_KEYS, 0..requests);
        let report = || unlike(&self.reports, &REPORT_KEYS, 0..COMMON_REPORTS);
        let request = request.map(|n| Request::NAMES[n]);
        request.or_else(|| report().map(|n| DeviceReport::NAMES[n]))
    }

    /// True if the other end has the same messages for controllers.
    #[cfg(feature = "controllers")]
    #[must_use]
    pub fn has_controllers(&self) -> bool {
        let request = unlike(
            &self.requests,
            &REQUEST_KEYS,
            AXES_REQUESTS..CONTROLLER_REQUESTS,
        );
        let report = unlike(&self.reports, &REPORT_KEYS, COMMON_REPORTS..REPORTS);
        request.is_none() && report.is_none()
    }

    /// True if the other end has the same message for surfaces.
    #[cfg(feature = "several-axes")]
    #[must_use]
    pub fn has_surfaces(&self) -> bool {
        unlike(&self.requests, &REQUEST_KEYS, CONTROLLER_REQUESTS..REQUESTS).is_none()
    }
}

/// The first key of these numbers that is missing or another one.
fn unlike(have: &[MessageKey], want: &[MessageKey], numbers: Range<usize>) -> Option<usize> {
    numbers.into_iter().find(|&n| have.get(n) != want.get(n))
}

const _: () = assert!(
    REQUEST_KEYS.len() == variants(Request::SCHEMA).len()
        && REPORT_KEYS.len() == variants(DeviceReport::SCHEMA).len()
        && REQUEST_KEYS.len() <= KEYS_MAX
        && REPORT_KEYS.len() <= KEYS_MAX,
    "a key for each message, and room for all"
);

/// A request as a type of its own, for its schema.
struct RequestVariant<const N: usize>;
struct ReportVariant<const N: usize>;

impl<const N: usize> Schema for RequestVariant<N> {
    const SCHEMA: &'static NamedType = &NamedType {
        name: "Request",
        ty: &DataModelType::Enum(&[variants(Request::SCHEMA)[N]]),
    };
}

impl<const N: usize> Schema for ReportVariant<N> {
    const SCHEMA: &'static NamedType = &NamedType {
        name: "Report",
        ty: &DataModelType::Enum(&[variants(DeviceReport::SCHEMA)[N]]),
    };
}

const fn variants(schema: &'static NamedType) -> &'static [&'static NamedVariant] {
    let DataModelType::Enum(variants) = schema.ty else {
        panic!("messages are an enumeration");
    };
    variants
}

/// The path distinguishes directions. The schema does not see that integers have a fixed length; all of them have.
const fn key<T: Schema>(path: &str) -> MessageKey {
    let hash = u64::from_le_bytes(Key::for_path::<T>(path).to_bytes());
    MessageKey((hash >> 32) as u32 ^ hash as u32)
}

macro_rules! keys {
    ($variant:ident: $($n:literal)*) => { [$(key::<$variant<$n>>(stringify!($variant))),*] };
}
use keys;
