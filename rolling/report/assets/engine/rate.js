// Sample rate of all records and of the engine.

export const RATE = 48000; // samples per second
