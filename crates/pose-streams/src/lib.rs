//! Object poses in the protocols of other tools: OSC messages, MAVLink frames, VRPN trackers, NatNet bodies.
//!
//! - [`Axes`]: the world's axes as other tools have them, with positions, quaternions and Euler angles.
//! - [`OscMessage`], [`OscLayout`]: Open Sound Control 1.0; plain poses, VRChat's trackers, Virtual Motion Tracker.
//! - [`MavlinkSender`], [`LocalFrame`], [`ResetCounter`]: `ODOMETRY` and `HEARTBEAT` of MAVLink 2.
//! - [`VrpnTrackers`], [`VrpnConnection`]: the server's side of VRPN.
//! - [`NatNetBodies`], [`NatNetRequest`], [`NatNetServer`]: the server's side of NatNet.
//! - [`MqttGreeting`], [`mqtt_publish`], [`MqttReader`]: a client of MQTT 5 that publishes.
//! - [`nt4_publish`], [`nt4_raw`]: a client of NetworkTables 4 that publishes.
//! - [`PsnTrackers`], [`freed_position`], [`OpenTrackIoCamera`]: PosiStageNet, Free-D and OpenTrackIO, for stages and
//!   virtual studios.
//!
//! Input is [`sextant_proto::ObjectPose`]: metres, x y z w, world with z up. Nothing here knows a socket or a clock.

mod axes;
mod freed;
mod mavlink;
mod mqtt;
mod natnet;
mod nt4;
mod opentrackio;
mod osc;
mod psn;
mod roster;
mod vrpn;

pub use axes::{Axes, euler_zxy_deg};
pub use freed::{FreeDCamera, freed_position};
pub use mavlink::odometry::LocalFrame;
pub use mavlink::reset_counter::ResetCounter;
pub use mavlink::{MavlinkSender, Sender, timesync_requests};
pub use mqtt::{
    MQTT_END, MQTT_PING, MQTT_PORT, MQTT_TLS_PORT, MqttAnswer, MqttGreeting, MqttReader, NoMqtt,
    Retention, mqtt_publish,
};
pub use natnet::bodies::NatNetBodies;
pub use natnet::request::{NatNetRequest, NatNetServer, natnet_bitstream, natnet_echo};
pub use natnet::{NATNET_COMMAND_PORT, NATNET_DATA_PORT, NatNetVersion};
pub use nt4::{
    NT4_PORT, NT4_PROTOCOL, NT4_SCHEMAS, nt4_pose, nt4_publish, nt4_raw, nt4_time_answer,
    nt4_time_request,
};
pub use opentrackio::{OpenTrackIoCamera, opentrackio_group};
pub use osc::layouts::{
    AddressError, AddressTemplate, MAX_VMT_TRACKERS, MAX_VRCHAT_TRACKERS, OscLayout,
};
pub use osc::{OscArgument, OscMessage};
pub use psn::{PSN_GROUP, PsnTrackers};
pub use vrpn::connection::{VrpnConnection, VrpnError, requested_port};
pub use vrpn::{TrackerReport, VRPN_PORT, VrpnTrackers};

/// The nearest finite `f32`.
fn narrowed(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}
