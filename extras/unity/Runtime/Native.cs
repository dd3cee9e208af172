// SPDX-License-Identifier: Apache-2.0
// Written by tools/c_header.py from host/c/haptogram.h.
using System;
using System.Runtime.InteropServices;

namespace Haptogram
{
    public enum Code
    {
        Ok = 0,
        Failed = 1,
        BadArgument = 2,
        BadInput = 3,
        Device = 4,
        Cancelled = 5,
    }

    public enum Event
    {
        None = 0,
        Start = 1,
        Mark = 2,
        Pass = 3,
        Period = 4,
        Modulation = 5,
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeProject
    {
        public uint size;
        public IntPtr toml;
        public IntPtr folder;
        public IntPtr shape_name;
        public IntPtr shape;
        public UIntPtr shape_bytes;
        public IntPtr name;
        public IntPtr file;
        public IntPtr cancel;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeFocus
    {
        public double x_m;
        public double y_m;
        public double z_m;
        public double amplitude;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePath
    {
        public uint size;
        public IntPtr board;
        public IntPtr array;
        public IntPtr foci;
        public IntPtr periods;
        public UIntPtr steps;
        public uint each;
        public ushort loops;
        public int board_computes;
        public IntPtr marks;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePort
    {
        public uint size;
        public IntPtr port;
        public uint baud;
        public uint patience_ms;
        public IntPtr rig;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeIdentity
    {
        public uint size;
        public uint version_major;
        public uint version_minor;
        public uint channels;
        public uint records;
        public uint sequence_depth;
        public uint clock_hz;
        public uint foci;
        public uint modulation_samples;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeStatus
    {
        public uint size;
        public int connected;
        public int enabled;
        public int stopped;
        public int busy;
        public uint present_index;
        public uint underruns;
        public uint refused_records;
        public uint watchdog_trips;
        public uint guard_trips;
        public uint frames_damaged;
        public ulong foci_sent;
        public double lead_s;
        public ulong patterns_late;
        public ulong patterns_lost;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePlaying
    {
        public uint size;
        public int loops;
        public uint watchdog_ms;
        public double seconds;
        public IntPtr am;
        public double step_s;
        public int stale_ms;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeTrigger
    {
        public uint size;
        public uint @event;
        public uint every_periods;
        public double pulse_s;
        public int active_low;
        public int gates;
        public double settle_s;
    }

    internal static class Native
    {
        internal const int Abi = 1;
        private const string Library = "haptogram";

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern int haptogram_abi();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern IntPtr haptogram_version();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern IntPtr haptogram_error();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern IntPtr haptogram_remedies();

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_compile(ref NativeProject project, out IntPtr image);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_compile_path(ref NativePath path, out IntPtr image);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_read_image(IntPtr hex_file, out IntPtr image);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_save_image(Image image, IntPtr hex_file);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern UIntPtr haptogram_image_hex(Image image, IntPtr to, UIntPtr room);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern UIntPtr haptogram_image_manifest(Image image, IntPtr to, UIntPtr room);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern UIntPtr haptogram_image_warnings(Image image, IntPtr to, UIntPtr room);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern UIntPtr haptogram_image_level(Image image, IntPtr to, UIntPtr room);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void haptogram_free_image(IntPtr image);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_pressure(Image image, uint record, ref double points_m, UIntPtr points, IntPtr pressure_pa);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_solve(IntPtr array, IntPtr foci, UIntPtr count, IntPtr method, IntPtr drives, ref UIntPtr elements);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_open(ref NativePort port, out IntPtr board);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern void haptogram_close(IntPtr board);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_identify(Board board, ref NativeIdentity identity);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_get_status(Board board, ref NativeStatus status);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_upload(Board board, Image image);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_play(Board board, ref NativePlaying playing);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_play_live(Board board, ref NativePlaying playing);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_set_focus(Board board, double x_m, double y_m, double z_m, double amplitude);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_play_patterns(Board board, ref NativePlaying playing);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_put_patterns(Board board, ref ushort words, UIntPtr patterns, ref UIntPtr taken);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_set_pattern(Board board, ref ushort words);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_wait(Board board, uint milliseconds, ref int busy);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_stop(Board board);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_shut_off(Board board);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_set_intensity(Board board, double factor);

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        internal static extern Code haptogram_set_trigger(Board board, ref NativeTrigger trigger);
    }
}
