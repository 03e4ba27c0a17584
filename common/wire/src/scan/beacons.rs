//! Beacons in a scan, in the layout that they have had from the beginning, with the readings of a common time beside.

use coaxle_clock::Span;
use serde::{Deserialize, Serialize};

use crate::beacon::{BeaconBefore, BeaconRequest, BeaconResponse, CommonStamp, Stamps};

/// A request without its reading.
#[derive(Serialize, Deserialize)]
pub(super) struct RequestOnWire {
    requester: u32,
    run: u64,
    number: u32,
    requested: i64,
    stamps: Stamps,
    before: Option<BeaconBefore>,
}

/// A response without the readings.
#[derive(Serialize, Deserialize)]
pub(super) struct ResponseOnWire {
    epoch: u64,
    request: RequestOnWire,
    received: Span,
    responded: Span,
    stamps: Stamps,
    before: Option<BeaconBefore>,
}

impl From<&BeaconRequest> for RequestOnWire {
    fn from(request: &BeaconRequest) -> Self {
        Self {
            requester: request.requester,
            run: request.run,
            number: request.number,
            requested: request.requested,
            stamps: request.stamps,
            before: request.before,
        }
    }
}

impl From<&BeaconResponse> for ResponseOnWire {
    fn from(response: &BeaconResponse) -> Self {
        Self {
            epoch: response.epoch,
            request: (&response.request).into(),
            received: response.received,
            responded: response.responded,
            stamps: response.stamps,
            before: response.before,
        }
    }
}

impl RequestOnWire {
    /// Returns the request with its reading; without one where there is no common time.
    pub(super) fn with(self, common: Option<Option<CommonStamp>>) -> BeaconRequest {
        BeaconRequest {
            requester: self.requester,
            run: self.run,
            number: self.number,
            requested: self.requested,
            stamps: self.stamps,
            before: self.before,
            takes_common_time: common.is_some(),
            common: common.flatten(),
        }
    }
}

impl ResponseOnWire {
    /// Returns the response with the readings of the requester and its own; without where there is no common time.
    pub(super) fn with(self, common: Option<[Option<CommonStamp>; 2]>) -> BeaconResponse {
        BeaconResponse {
            epoch: self.epoch,
            request: self.request.with(common.map(|[requester, _]| requester)),
            received: self.received,
            responded: self.responded,
            stamps: self.stamps,
            before: self.before,
            common: common.and_then(|[_, own]| own),
        }
    }
}
