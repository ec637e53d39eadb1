//! A camera of software: it offers what a test tells it, fills buffers with what a test gives it, and vanishes at will.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use sextant_process::Shutdown;

use super::device::{
    Api, Buffer, Control, ControlKind, Device, Format, Fraction, Identity, Intervals, Sizes, Wake,
};
use super::{CAP_STREAMING, CAP_VIDEO_CAPTURE, CAP_VIDEO_CAPTURE_MPLANE};

/// A format that it offers: code, size, images a second.
pub(super) type Offered = ([u8; 4], [u32; 2], u32);

/// An image that waits to be taken.
#[derive(Debug, Clone)]
pub(super) struct FakeImage {
    pub(super) bytes: Vec<u8>,
    pub(super) sequence: u32,
    pub(super) flags: u32,
    pub(super) timestamp: [i64; 2],
}

/// The camera; clones are one.
#[derive(Debug, Clone)]
pub(super) struct FakeDevice {
    pub(super) state: Rc<FakeState>,
}

#[derive(Debug)]
pub(super) struct FakeState {
    pub(super) api: Api,
    pub(super) offered: Vec<Offered>,
    /// Whether it lists its formats.
    pub(super) lists: bool,
    /// Bytes that it adds to each row.
    pub(super) padding: u32,
    pub(super) controls: RefCell<Vec<(Control, i32)>>,
    /// Every control that was set, in order.
    pub(super) set: RefCell<Vec<(u32, i32)>>,
    pub(super) interval: Cell<Option<Fraction>>,
    pub(super) images: RefCell<VecDeque<FakeImage>>,
    /// The error of every request from now on.
    pub(super) failure: Cell<Option<i32>>,
    pub(super) is_changed: Cell<bool>,
    pub(super) is_streaming: Cell<bool>,
    queued: RefCell<VecDeque<u32>>,
    buffers: RefCell<Vec<Vec<u8>>>,
}

impl FakeDevice {
    pub(super) fn new(offered: &[Offered]) -> Self {
        Self::with(offered, |_| {})
    }

    pub(super) fn with(offered: &[Offered], change: impl FnOnce(&mut FakeState)) -> Self {
        let mut state = FakeState {
            api: Api::SinglePlanar,
            offered: offered.to_vec(),
            lists: true,
            padding: 0,
            controls: RefCell::default(),
            set: RefCell::default(),
            interval: Cell::default(),
            images: RefCell::default(),
            failure: Cell::default(),
            is_changed: Cell::default(),
            is_streaming: Cell::default(),
            queued: RefCell::default(),
            buffers: RefCell::default(),
        };
        change(&mut state);
        Self {
            state: Rc::new(state),
        }
    }

    pub(super) fn push(&self, image: FakeImage) {
        self.state.images.borrow_mut().push_back(image);
    }

    fn check(&self, api: Option<Api>) -> io::Result<()> {
        match self.state.failure.get() {
            Some(errno) => Err(io::Error::from_raw_os_error(errno)),
            None if api.is_some_and(|api| api != self.state.api) => invalid(),
            None => Ok(()),
        }
    }
}

/// An integer control, or a switch.
pub(super) fn control(id: u32, title: &str, kind: ControlKind, range: [i32; 2]) -> (Control, i32) {
    let control = Control {
        id,
        kind,
        title: title.to_owned(),
        range,
        step: 1,
        default: range[0],
        flags: 0,
    };
    (control, range[0])
}

fn invalid<T>() -> io::Result<T> {
    Err(io::Error::from_raw_os_error(libc::EINVAL))
}

impl Device for FakeDevice {
    fn identity(&self) -> io::Result<Identity> {
        self.check(None)?;
        let capture = match self.state.api {
            Api::SinglePlanar => CAP_VIDEO_CAPTURE,
            Api::MultiPlanar => CAP_VIDEO_CAPTURE_MPLANE,
        };
        Ok(Identity {
            driver: "fake".to_owned(),
            card: "Fake Camera".to_owned(),
            bus: "nowhere".to_owned(),
            abilities: capture | CAP_STREAMING,
        })
    }

    fn nth_format(&self, api: Api, n: u32) -> io::Result<[u8; 4]> {
        self.check(Some(api))?;
        let mut codes: Vec<[u8; 4]> = self.state.offered.iter().map(|(code, ..)| *code).collect();
        codes.dedup();
        match codes.get(n as usize) {
            Some(code) if self.state.lists => Ok(*code),
            _ => invalid(),
        }
    }

    fn nth_size(&self, fourcc: [u8; 4], n: u32) -> io::Result<Sizes> {
        let of_format = |(code, size, _): &Offered| (*code == fourcc).then_some(*size);
        let mut sizes = self.state.offered.iter().filter_map(of_format);
        sizes
            .nth(n as usize)
            .map_or_else(invalid, |size| Ok(Sizes::One(size)))
    }

    fn nth_interval(&self, fourcc: [u8; 4], size: [u32; 2], n: u32) -> io::Result<Intervals> {
        let fits = |offered: &&Offered| (offered.0, offered.1) == (fourcc, size);
        let mut rates = self.state.offered.iter().filter(fits);
        let rate = rates.nth(n as usize);
        rate.map_or_else(invalid, |(.., hz)| Ok(Intervals::One(Fraction([1, *hz]))))
    }

    fn set_format(&self, api: Api, fourcc: [u8; 4], size: [u32; 2]) -> io::Result<Format> {
        self.check(Some(api))?;
        let offered = &self.state.offered;
        let exact = offered.iter().find(|o| (o.0, o.1) == (fourcc, size));
        let alike = exact.or_else(|| offered.iter().find(|o| o.0 == fourcc));
        let Some((fourcc, size, _)) = alike.or_else(|| offered.first()) else {
            return invalid();
        };
        let bytes_a_pixel = match fourcc {
            b"YUYV" | b"Y10 " | b"RG10" => 2,
            _ => 1,
        };
        Ok(Format {
            fourcc: *fourcc,
            size: *size,
            stride: size[0] * bytes_a_pixel + self.state.padding,
        })
    }

    fn set_interval(&self, api: Api, interval: Fraction) -> io::Result<Fraction> {
        self.check(Some(api))?;
        self.state.interval.set(Some(interval));
        Ok(interval)
    }

    fn control_after(&self, after: u32) -> io::Result<Control> {
        let controls = self.state.controls.borrow();
        let next = controls.iter().find(|(control, _)| control.id > after);
        next.map_or_else(invalid, |(control, _)| Ok(control.clone()))
    }

    fn menu_entry(&self, _: u32, index: u32) -> io::Result<String> {
        match index {
            1 => Ok("Manual Mode".to_owned()),
            3 => Ok("Aperture Priority Mode".to_owned()),
            _ => invalid(),
        }
    }

    fn control(&self, id: u32) -> io::Result<i32> {
        let controls = self.state.controls.borrow();
        let found = controls.iter().find(|(control, _)| control.id == id);
        found.map_or_else(invalid, |(_, value)| Ok(*value))
    }

    fn set_control(&self, id: u32, value: i32) -> io::Result<()> {
        let mut controls = self.state.controls.borrow_mut();
        let found = controls.iter_mut().find(|(control, _)| control.id == id);
        let Some((_, current)) = found else {
            return invalid();
        };
        *current = value;
        self.state.set.borrow_mut().push((id, value));
        Ok(())
    }

    fn watch_source(&self) -> io::Result<()> {
        Err(io::Error::from_raw_os_error(libc::ENOTTY))
    }

    fn map_buffers(&mut self, api: Api, count: u32) -> io::Result<u32> {
        self.check(Some(api))?;
        *self.state.buffers.borrow_mut() = vec![Vec::new(); count as usize];
        Ok(count)
    }

    fn queue(&self, api: Api, index: u32) -> io::Result<()> {
        self.check(Some(api))?;
        let mut queued = self.state.queued.borrow_mut();
        if queued.contains(&index) {
            return invalid();
        }
        queued.push_back(index);
        Ok(())
    }

    fn dequeue(&self, api: Api) -> io::Result<Buffer> {
        self.check(Some(api))?;
        let again = || io::Error::from_raw_os_error(libc::EAGAIN);
        if !self.state.is_streaming.get() {
            return invalid();
        }
        let mut images = self.state.images.borrow_mut();
        if images.is_empty() {
            return Err(again());
        }
        let index = self
            .state
            .queued
            .borrow_mut()
            .pop_front()
            .ok_or_else(again)?;
        let image = images.pop_front().ok_or_else(again)?;
        let end = image.bytes.len();
        self.state.buffers.borrow_mut()[index as usize] = image.bytes;
        Ok(Buffer {
            index,
            flags: image.flags,
            timestamp: image.timestamp,
            sequence: image.sequence,
            image: [0, end],
        })
    }

    fn look_at(&self, buffer: &Buffer, look: &mut dyn FnMut(&[u8])) {
        let buffers = self.state.buffers.borrow();
        let [begin, end] = buffer.image;
        look(&buffers[buffer.index as usize][begin..end]);
    }

    fn start(&self, api: Api) -> io::Result<()> {
        self.check(Some(api))?;
        self.state.is_streaming.set(true);
        Ok(())
    }

    fn stop(&self, _: Api) -> io::Result<()> {
        self.state.is_streaming.set(false);
        self.state.queued.borrow_mut().clear();
        self.check(None)
    }

    fn wait(&self, shutdown: &Shutdown, _: Duration) -> io::Result<Wake> {
        Ok(match shutdown.is_requested() {
            true => Wake::Nothing,
            false if self.state.is_changed.get() => Wake::Changed,
            // A device that is gone wakes its readers, too.
            false if self.state.failure.get().is_some() => Wake::Ready,
            false if self.state.images.borrow().is_empty() => Wake::Nothing,
            false => Wake::Ready,
        })
    }
}
