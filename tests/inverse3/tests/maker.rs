//! The maker's crate `haply`, as it is, at the emulated service.

use haply::HaplyDevice;
use haply::device_model::{
    Config, DampingConfig, Force, ForceInput, Inverse3Configure, Inverse3Device, PresetConfig,
    ProfileConfig, SessionConfigure,
};
use haply::http::InverseHttpClient;
use haptic_emulator::inverse3::CENTRE_M;
use inverse3_by_its_maker::{ID, Running};
use std::time::Duration;

async fn connected(running: &Running) -> HaplyDevice {
    let device = HaplyDevice::new(&running.http(), &running.ws()).await;
    device.expect("it connects")
}

/// What the client has of the device once that is as wanted; however long that takes.
async fn seen(
    device: &mut HaplyDevice,
    wanted: impl Fn(&Inverse3Device) -> bool,
) -> Inverse3Device {
    loop {
        device.send_force_full_render().await.expect("sent");
        let state = device.read_state().await.expect("a state");
        if let Some(found) = state.inverse3.into_iter().find(|found| wanted(found)) {
            return found;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

fn force(x: f32, y: f32, z: f32) -> Vec<ForceInput> {
    vec![ForceInput {
        device_id: ID.to_owned(),
        forces: Force { x, y, z },
    }]
}

#[tokio::test]
async fn over_http_it_reads_version_and_devices() {
    let running = Running::start();
    let client = InverseHttpClient::new(&running.http());
    let version = client.get_version().await.expect("a version");
    assert_eq!(version.project_version, "3.5.0");
    let devices = client.get_devices().await.expect("devices");
    let [Config::DeviceConfig(config), Config::WVGConfig(grip)] = devices.as_slice() else {
        panic!("{devices:?}");
    };
    assert_eq!(config.id, ID);
    assert_eq!(grip.id, "1102");
    let filters = config.filters.as_ref().expect("filters");
    assert_eq!(filters.damping.expect("damping").scalar, 5.0);
    assert_eq!(filters.force_gate.expect("gate").gain, 0.3);
}

#[tokio::test]
async fn it_reads_the_whole_state_and_settings_that_it_makes() {
    let running = Running::start();
    let mut device = connected(&running).await;
    let first = seen(&mut device, |found| found.config.is_some()).await;
    let place = first.state.cursor_position.expect("a position");
    let centre = CENTRE_M.map(|axis| axis as f32);
    assert_eq!([place.x, place.y, place.z], centre);
    assert!(first.state.cursor_velocity.is_some() && first.state.transform.is_some());
    assert!(first.status.calibrated && first.status.ready);
    let session = SessionConfigure {
        profile: Some(ProfileConfig {
            name: "by its maker".to_owned(),
            required_version: Some(">=3.5".to_owned()),
        }),
        ..SessionConfigure::default()
    };
    device
        .configure_session(session, Some(true))
        .await
        .expect("sent");
    let wanted = Inverse3Configure {
        preset: Some(PresetConfig {
            preset: "arm_front_centered".to_owned(),
        }),
        damping: Some(DampingConfig {
            scalar: Some(0.0),
            vector: None,
        }),
        ..Inverse3Configure::default()
    };
    device
        .configure_inverse3(ID, wanted, Some(true))
        .await
        .expect("sent");
    let set = seen(&mut device, |found| {
        let config = found.config.as_ref();
        config.is_some_and(|config| config.preset.as_deref() == Some("arm_front_centered"))
    });
    let set = set.await;
    let place = set.state.cursor_position.expect("a position");
    assert_eq!([place.x, place.y, place.z], [0.0; 3]);
    let filters = set
        .config
        .and_then(|config| config.filters)
        .expect("filters");
    assert_eq!(filters.damping.expect("damping").scalar, 0.0);
}

#[tokio::test]
async fn a_force_of_it_arrives_moves_the_cursor_and_ends_with_it() {
    let running = Running::start();
    let mut device = connected(&running).await;
    device
        .update_force(force(0.5, -0.25, 1.0), Some(true), Some(true))
        .await
        .expect("sent");
    let pushed = seen(&mut device, |found| {
        found
            .state
            .cursor_position
            .is_some_and(|place| place.z > CENTRE_M[2] as f32 + 1e-3)
    });
    let place = pushed.await.state.cursor_position.expect("a position");
    assert!(place.x > 0.0 && place.y < CENTRE_M[1] as f32, "{place:?}");
    assert!((running.service().counted().largest_n - 1.145_643_9).abs() < 1e-6);
    device.shutdown().await.expect("closed");
    // It is closed when the service has read so.
    while running.service().first().expect("there").1 != [0.0; 3] {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

#[tokio::test]
async fn it_reads_a_grip_that_points_somewhere_and_has_buttons() {
    let running = Running::start();
    let mut device = connected(&running).await;
    let grip = loop {
        device.send_force_full_render().await.expect("sent");
        let state = device.read_state().await.expect("a state");
        if let Some(grip) = state.wireless_verse_grip.into_iter().next() {
            break grip;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    };
    assert_eq!(grip.device_id, "1102");
    assert_eq!(grip.state.orientation.expect("an orientation").w, 1.0);
    let buttons = grip.state.buttons.expect("buttons");
    assert!(!buttons.a && !buttons.b && !buttons.c);
    assert!(grip.status.ready && grip.status.connected);
}

#[tokio::test]
async fn a_force_that_is_not_to_be_executed_is_not() {
    let running = Running::start();
    let mut device = connected(&running).await;
    device
        .update_force(force(0.0, 0.0, 1.0), Some(false), Some(true))
        .await
        .expect("sent");
    seen(&mut device, |found| found.config.is_some()).await;
    assert_eq!(running.service().counted().largest_n, 0.0);
}
