//! Images of one camera in shared memory, lent without a copy through iceoryx2.
