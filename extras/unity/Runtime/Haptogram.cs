// SPDX-License-Identifier: Apache-2.0
// Haptogram for C#: images and boards. Lengths are metres in the array's frame: x right, y forward, z up, right-handed.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Haptogram
{
    /// <summary>What went wrong, in words; the words are the library's, the same in all languages.</summary>
    public sealed class HaptogramException : Exception
    {
        public Code Code { get; }

        /// <summary>The settings that could mend it, as a project file calls them.</summary>
        public string[] Remedies { get; }

        internal HaptogramException(Code code, string message, string remedies) : base(message)
        {
            Code = code;
            Remedies = remedies.Length == 0 ? new string[0] : remedies.Split(',');
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Focus
    {
        public double X, Y, Z;

        /// <summary>Of the pressure, 0 to 1 of the most that the array can make there.</summary>
        public double Amplitude;

        public Focus(double x, double y, double z, double amplitude = 1.0)
        {
            X = x;
            Y = y;
            Z = z;
            Amplitude = amplitude;
        }
    }

    /// <summary>Text as the library wants it, while it lives.</summary>
    internal sealed class Utf8 : IDisposable
    {
        internal IntPtr Pointer { get; private set; }

        internal Utf8(string text)
        {
            if (text == null) return;
            byte[] bytes = Encoding.UTF8.GetBytes(text + "\0");
            Pointer = Marshal.AllocHGlobal(bytes.Length);
            Marshal.Copy(bytes, 0, Pointer, bytes.Length);
        }

        public void Dispose()
        {
            Marshal.FreeHGlobal(Pointer);
            Pointer = IntPtr.Zero;
        }

        internal static string Read(IntPtr pointer)
        {
            int length = 0;
            while (Marshal.ReadByte(pointer, length) != 0) ++length;
            return Read(pointer, length);
        }

        internal static string Read(IntPtr pointer, int length)
        {
            var bytes = new byte[length];
            Marshal.Copy(pointer, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }
    }

    public static class Library
    {
        public static string Version => Utf8.Read(Native.haptogram_version());

        internal static void Check(Code code)
        {
            if (code != Code.Ok)
                throw new HaptogramException(code, Utf8.Read(Native.haptogram_error()), Utf8.Read(Native.haptogram_remedies()));
        }

        internal static uint SizeOf<T>() => (uint)Marshal.SizeOf(typeof(T));

        /// <summary>Drives that make several foci at the same time: a real and an imaginary part for each element.</summary>
        public static double[] Solve(string array, Focus[] foci, string method = null)
        {
            GCHandle pinned = GCHandle.Alloc(foci, GCHandleType.Pinned);
            using (var name = new Utf8(array))
            using (var how = new Utf8(method))
            {
                try
                {
                    var elements = UIntPtr.Zero;
                    var count = (UIntPtr)foci.Length;
                    // The first call says how many elements there are; no array has none.
                    Code first = Native.haptogram_solve(name.Pointer, pinned.AddrOfPinnedObject(), count, how.Pointer, IntPtr.Zero, ref elements);
                    if (elements == UIntPtr.Zero) Check(first);
                    var drives = new double[2 * (int)elements];
                    GCHandle filled = GCHandle.Alloc(drives, GCHandleType.Pinned);
                    try
                    {
                        Check(Native.haptogram_solve(name.Pointer, pinned.AddrOfPinnedObject(), count, how.Pointer, filled.AddrOfPinnedObject(), ref elements));
                    }
                    finally
                    {
                        filled.Free();
                    }
                    return drives;
                }
                finally
                {
                    pinned.Free();
                }
            }
        }
    }

    /// <summary>The contents of a board's memories, and what they mean.</summary>
    public sealed class Image : SafeHandle
    {
        private Image(IntPtr found) : base(IntPtr.Zero, true)
        {
            SetHandle(found);
        }

        public override bool IsInvalid => handle == IntPtr.Zero;

        protected override bool ReleaseHandle()
        {
            Native.haptogram_free_image(handle);
            return true;
        }

        /// <summary>Of the text of a project file; names in it begin in the folder.</summary>
        public static Image Compile(string toml, string folder = null)
        {
            using (var text = new Utf8(toml))
            using (var where = new Utf8(folder))
            {
                var project = new NativeProject { size = Library.SizeOf<NativeProject>(), toml = text.Pointer, folder = where.Pointer };
                IntPtr found;
                Library.Check(Native.haptogram_compile(ref project, out found));
                return new Image(found);
            }
        }

        /// <summary>Of foci one after the other, each for so many carrier periods; null: one.</summary>
        /// <param name="boardComputes">an image of foci, for boards that compute their phases; needed for live foci</param>
        /// <param name="marks">of each focus: not 0 when the trigger output of a board tells its beginning</param>
        public static Image OfFoci(Focus[] foci, uint[] periods = null, string board = null, string array = null, bool boardComputes = false, byte[] marks = null)
        {
            if (periods != null && periods.Length != foci.Length) throw new ArgumentException("give one for each focus", "periods");
            if (marks != null && marks.Length != foci.Length) throw new ArgumentException("give one for each focus", "marks");
            GCHandle places = GCHandle.Alloc(foci, GCHandleType.Pinned), times = GCHandle.Alloc(periods, GCHandleType.Pinned);
            GCHandle marked = GCHandle.Alloc(marks, GCHandleType.Pinned);
            using (var boardName = new Utf8(board))
            using (var arrayName = new Utf8(array))
            {
                try
                {
                    var path = new NativePath
                    {
                        size = Library.SizeOf<NativePath>(), board = boardName.Pointer, array = arrayName.Pointer, foci = places.AddrOfPinnedObject(),
                        periods = periods == null ? IntPtr.Zero : times.AddrOfPinnedObject(), steps = (UIntPtr)foci.Length, board_computes = boardComputes ? 1 : 0,
                        marks = marks == null ? IntPtr.Zero : marked.AddrOfPinnedObject(),
                    };
                    IntPtr found;
                    Library.Check(Native.haptogram_compile_path(ref path, out found));
                    return new Image(found);
                }
                finally
                {
                    places.Free();
                    times.Free();
                    marked.Free();
                }
            }
        }

        public static Image Read(string hexFile)
        {
            using (var name = new Utf8(hexFile))
            {
                IntPtr found;
                Library.Check(Native.haptogram_read_image(name.Pointer, out found));
                return new Image(found);
            }
        }

        public void Save(string hexFile)
        {
            using (var name = new Utf8(hexFile)) Library.Check(Native.haptogram_save_image(this, name.Pointer));
        }

        private delegate UIntPtr Copies(Image image, IntPtr to, UIntPtr room);

        private string TextOf(Copies copies)
        {
            var length = (int)copies(this, IntPtr.Zero, UIntPtr.Zero);
            IntPtr to = Marshal.AllocHGlobal(length + 1);
            try
            {
                copies(this, to, (UIntPtr)length);
                return Utf8.Read(to, length);
            }
            finally
            {
                Marshal.FreeHGlobal(to);
            }
        }

        /// <summary>Intel HEX.</summary>
        public string Hex => TextOf(Native.haptogram_image_hex);

        /// <summary>JSON.</summary>
        public string Manifest => TextOf(Native.haptogram_image_manifest);

        /// <summary>What is odd about it and does no harm, a sentence a line.</summary>
        public string Warnings => TextOf(Native.haptogram_image_warnings);

        /// <summary>What its pressures rest on: a nominal level, or a calibrated one.</summary>
        public string Level => TextOf(Native.haptogram_image_level);

        /// <summary>The amplitude of the pressure, Pa, at x, y, z, x, y, …, while a record plays; 0: over the whole sequence.</summary>
        public double[] Pressure(ReadOnlySpan<double> pointsM, uint record = 0)
        {
            if (pointsM.Length % 3 != 0) throw new ArgumentException("expected three coordinates for each point", "pointsM");
            var found = new double[pointsM.Length / 3];
            GCHandle to = GCHandle.Alloc(found, GCHandleType.Pinned);
            try
            {
                Library.Check(Native.haptogram_pressure(this, record, ref MemoryMarshal.GetReference(pointsM), (UIntPtr)found.Length, to.AddrOfPinnedObject()));
                return found;
            }
            finally
            {
                to.Free();
            }
        }
    }

    public struct Status
    {
        public bool Connected, Enabled, Stopped, Busy;
        public uint PresentIndex, Underruns, RefusedRecords, WatchdogTrips, GuardTrips, FramesDamaged;
        public ulong FociSent;
        public double LeadSeconds;
        public ulong PatternsLate, PatternsLost;
    }

    /// <summary>A board. Disposing of it turns its outputs off.</summary>
    public sealed class Board : SafeHandle
    {
        /// <param name="port">/dev/ttyUSB0, ftdi:…, or reference:NAME, a simulated board in this process</param>
        /// <param name="baud">0: it is found</param>
        public Board(string port, uint baud = 0, uint patienceMs = 3000) : base(IntPtr.Zero, true)
        {
            if (Native.haptogram_abi() != Native.Abi)
                throw new InvalidOperationException($"the library has version {Native.haptogram_abi()} of its interface, and this is for {Native.Abi}");
            using (var name = new Utf8(port))
            {
                var wanted = new NativePort { size = Library.SizeOf<NativePort>(), port = name.Pointer, baud = baud, patience_ms = patienceMs };
                IntPtr found;
                Library.Check(Native.haptogram_open(ref wanted, out found));
                SetHandle(found);
            }
        }

        public override bool IsInvalid => handle == IntPtr.Zero;

        protected override bool ReleaseHandle()
        {
            Native.haptogram_close(handle);
            return true;
        }

        public uint Channels => Identity().channels;

        /// <summary>Most foci at the same time that it computes by itself; 0: none.</summary>
        public uint Foci => Identity().foci;

        private NativeIdentity Identity()
        {
            var found = new NativeIdentity { size = Library.SizeOf<NativeIdentity>() };
            Library.Check(Native.haptogram_identify(this, ref found));
            return found;
        }

        /// <summary>What was heard last; nothing is waited for.</summary>
        public Status Status
        {
            get
            {
                var found = new NativeStatus { size = Library.SizeOf<NativeStatus>() };
                Library.Check(Native.haptogram_get_status(this, ref found));
                return new Status
                {
                    Connected = found.connected != 0, Enabled = found.enabled != 0, Stopped = found.stopped != 0, Busy = found.busy != 0,
                    PresentIndex = found.present_index, Underruns = found.underruns, RefusedRecords = found.refused_records,
                    WatchdogTrips = found.watchdog_trips, GuardTrips = found.guard_trips, FramesDamaged = found.frames_damaged,
                    FociSent = found.foci_sent, LeadSeconds = found.lead_s,
                    PatternsLate = found.patterns_late, PatternsLost = found.patterns_lost,
                };
            }
        }

        /// <summary>Writes what the board does not hold already.</summary>
        public void Upload(Image image)
        {
            Library.Check(Native.haptogram_upload(this, image));
        }

        private delegate Code Begins(Board board, ref NativePlaying playing);

        private void Begin(Begins begins, int loops, double seconds, string am, uint watchdogMs, int staleMs = 0)
        {
            using (var waveform = new Utf8(am))
            {
                var playing = new NativePlaying { size = Library.SizeOf<NativePlaying>(), loops = loops, seconds = seconds, am = waveform.Pointer, watchdog_ms = watchdogMs, stale_ms = staleMs };
                Library.Check(begins(this, ref playing));
            }
        }

        /// <summary>Begins to play what was uploaded, and returns.</summary>
        /// <param name="loops">passes; 0: as the image says; −1: for ever</param>
        public void Play(int loops = 0, double seconds = 0.0, string am = null, uint watchdogMs = 500)
        {
            Begin(Native.haptogram_play, loops, seconds, am, watchdogMs);
        }

        /// <summary>Begins to play the focus that was set last. An image of foci must have been uploaded.</summary>
        /// <param name="staleMs">silent when it was set longer ago; 0: as watchdogMs; −1: it stays</param>
        public void PlayLive(double seconds = 0.0, string am = null, uint watchdogMs = 500, int staleMs = 0)
        {
            Begin(Native.haptogram_play_live, 0, seconds, am, watchdogMs, staleMs);
        }

        /// <summary>Never waits; the newest wins. One that is refused is silence.</summary>
        public void SetFocus(double x, double y, double z, double amplitude = 1.0)
        {
            Library.Check(Native.haptogram_set_focus(this, x, y, z, amplitude));
        }

        public void SetFocus(Focus focus)
        {
            SetFocus(focus.X, focus.Y, focus.Z, focus.Amplitude);
        }

        /// <summary>Begins to play patterns, a new one in each carrier period.</summary>
        /// <param name="staleMs">silent when the newest was put longer ago; 0: as watchdogMs; −1: the last one stays</param>
        public void PlayPatterns(double seconds = 0.0, string am = null, uint watchdogMs = 500, int staleMs = 0)
        {
            Begin(Native.haptogram_play_patterns, 0, seconds, am, watchdogMs, staleMs);
        }

        /// <summary>Appends patterns, each a word for each channel: phase in 1/256 of the period in bits 7…0, amplitude in bits 15…8. Never waits.</summary>
        /// <returns>how many of them there was room for</returns>
        public int PutPatterns(ReadOnlySpan<ushort> words)
        {
            if (words.Length % Channels != 0) throw new ArgumentException($"expected whole patterns of {Channels} words", "words");
            var taken = UIntPtr.Zero;
            Library.Check(Native.haptogram_put_patterns(this, ref MemoryMarshal.GetReference(words), (UIntPtr)(words.Length / Channels), ref taken));
            return (int)taken;
        }

        /// <summary>One pattern that goes on, in the place of all that wait. Never waits.</summary>
        public void SetPattern(ReadOnlySpan<ushort> words)
        {
            if (words.Length != Channels) throw new ArgumentException($"expected {Channels} words", "words");
            Library.Check(Native.haptogram_set_pattern(this, ref MemoryMarshal.GetReference(words)));
        }

        /// <summary>Waits until what was begun has ended, at most so long. Whether it goes on.</summary>
        public bool Wait(uint milliseconds)
        {
            int busy = 0;
            Library.Check(Native.haptogram_wait(this, milliseconds, ref busy));
            return busy != 0;
        }

        /// <summary>Sets up the trigger output, on boards that have one.</summary>
        public void SetTrigger(Event what, uint everyPeriods = 1, double pulseSeconds = 1e-3)
        {
            var trigger = new NativeTrigger { size = Library.SizeOf<NativeTrigger>(), @event = (uint)what, every_periods = everyPeriods, pulse_s = pulseSeconds };
            Library.Check(Native.haptogram_set_trigger(this, ref trigger));
        }

        /// <summary>Ends what was begun in good order, and turns the outputs off.</summary>
        public void Stop()
        {
            Library.Check(Native.haptogram_stop(this));
        }

        /// <summary>Turns the outputs off ahead of everything.</summary>
        public void ShutOff()
        {
            Library.Check(Native.haptogram_shut_off(this));
        }

        /// <summary>Of all that the uploaded image plays, 0 to 1; also while it plays.</summary>
        public void SetIntensity(double factor)
        {
            Library.Check(Native.haptogram_set_intensity(this, factor));
        }
    }
}
