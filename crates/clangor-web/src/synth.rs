//! The synthesiser of a page: events go in, blocks of two channels come out.
