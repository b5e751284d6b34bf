//! Arm MPS2 with the FPGA image AN386 (Cortex-M4F r0p1), QEMU's `mps2-an386`.
//!
//! Source: Arm, *Application Note AN386: ARM Cortex-M4 SMM on V2M-MPS2*, memory map and interrupts.

/// Name, as the host sees it.
pub const NAME: &str = "mps2-an386";

/// Processor and peripheral clock, Hz: OSCCLK 50 MHz / 2.
pub(crate) const CLOCK_HZ: u32 = 25_000_000;

/// Clocks in a microsecond: 25 MHz / 1 MHz = 25. A tick of 1 ms is 25 MHz / 1000 = 25 000, reload
/// 24 999; one of 10 ms 250 000, within the 24 bits of `SysTick`.
pub(crate) const CLOCKS_PER_US: u32 = CLOCK_HZ / 1_000_000;

/// UART0, a CMSDK APB UART.
pub(crate) const UART0: usize = 0x4000_4000;

/// Divider: 25 MHz / 921 600 = 27.13, so 27: 925 926 baud, +0.47 %. The hardware's least is 16.
pub(crate) const UART_DIVIDER: u32 = 27;

/// FPGA system control and I/O: the microsecond counter.
pub(crate) const FPGAIO: usize = 0x4002_8000;
