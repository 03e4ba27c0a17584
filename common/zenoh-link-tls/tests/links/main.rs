//! Links as Zenoh opens them, over loopback, with certificates of an authority of their own.

mod authority;
mod every_transport;
mod floods;
mod tls;
