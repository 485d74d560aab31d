"""The radar as built: waveform, antennas, scan timing, receiver; the mast and the boat that carry it.

    transmit × interferogram
                        single, switched × single_pulse, alternating_pulse: four modes from one signal path. `array.py`
                        has the table of who sends and who hears.
    waveform            pulse: rectangular, through a Gaussian filter; chirp: linear FM, matched filter and
                        compression_window, its near range eclipsed sample by sample
    transmitter         coherent, or magnetron: each pulse starts with a random phase on a carrier that strays, which
                        the receiver may measure and take off (coherent_on_receive); `receiver.py` has the phases
    [radar.antenna]     slotted_waveguide (Taylor's one-parameter taper), gaussian, file (CSV, MSI/Planet). The gain is
                        that of the pattern itself; feed = "end" squints off its design frequency
    [[radar.antennas]]  any number, each with offset_m, role, pattern, bandwidth, gain and phase of its channel, and an
                        error of its position. The keys of two stacked antennas are the short form
    scan                turning: sectors, several turns while the sea runs on; staring, for stare_s a map
    [radar.receiver]    baseband: ideal complex gates; digital: the intermediate frequency undersampled, quantised,
                        saturating, with automatic gain and sensitivity-time control, mixed down, filtered, decimated
    [platform]          fixed, sinusoidal, wave_following (the boat follows the sea that the radar sees), file; list,
                        trim, speed, lever arm
    [platform.sensors]  bias, noise, rate, latency. The true motion moves the antennas, the measured one goes to the
                        retrieval

Signs and files:

* Roll + starboard down, pitch + bow up, heading clockwise from north. `offset_m` counts right, ahead, up from the
  middle of the array; lever arms and what is fixed to the boat count starboard, forward, up. `sector_deg` counts from
  true north; yaw swings it, a squint turns it.
* A motion file is CSV with `time_s` and any of `roll_deg`, `pitch_deg`, `heading_deg`, `heave_m`, `x_m`, `y_m`.
* A pattern file is CSV (`cut,angle_deg,gain_db`; the cut is azimuth or elevation) or MSI/Planet, whose vertical angles
  count downwards.
* A turn is not a snapshot: beside its start the map is a turn younger than on the other side, and a boat under way
  leaves a gap there.
* Keys of a switch that is off (`adc_bits` with baseband, `roll_period_s` with fixed, …) are ignored.

Scenes: `rough_ride` follows the waves with sensors that err; `harbour` has a buoy, a vessel, a pier and the boat's own
wheelhouse (its error figures include the heights of the objects, compared with the sea).

Evidence: validation/models/echoes.md.
"""
