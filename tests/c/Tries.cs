// SPDX-License-Identifier: Apache-2.0
// What a program in C# does, under mono; test_csharp.py reads what it prints.
using System;
using System.Diagnostics;
using Haptogram;

static class Tries
{
    static void Compiles(string toml)
    {
        using (Image image = Image.Compile(toml))
        {
            Console.WriteLine("hex " + image.Hex.Length + " manifest " + image.Manifest.Length);
            Console.WriteLine(image.Level);
            image.Save("csharp.hex");
        }
        using (Image image = Image.Read("csharp.hex")) Console.WriteLine("pressure " + image.Pressure(new[] { 0, 0, 0.15 }, 1)[0].ToString("R"));
        Console.WriteLine("solved " + Library.Solve("tile-10x10", new[] { new Focus(0.01, 0, 0.15), new Focus(-0.01, 0, 0.15) }).Length);
    }

    static void Fails()
    {
        try
        {
            Image.Compile("format = \"haptogram-project-1\"\npoints = 0\n");
        }
        catch (HaptogramException error)
        {
            Console.WriteLine("error " + (int)error.Code + " " + error.Message);
        }
    }

    static string Refused(Action use)
    {
        try
        {
            use();
            return "nothing";
        }
        catch (ObjectDisposedException error)
        {
            return error.GetType().Name;
        }
    }

    static void IsGone(string port)
    {
        var board = new Board(port);
        board.Dispose();
        Image image = Image.OfFoci(new[] { new Focus(0, 0, 0.15) });
        image.Dispose();
        Console.WriteLine("gone " + Refused(() => board.Wait(0)) + " " + Refused(() => board.PlayLive()) + " " + Refused(() => image.Save("gone.hex")));
    }

    static void Moves(string port, double seconds)
    {
        using (Image image = Image.OfFoci(new[] { new Focus(0, 0, 0.15) }, null, "tile-100-wide", "tile-10x10", true))
        using (var board = new Board(port))
        {
            board.Upload(image);
            board.PlayLive(am: "sine:200");
            var watch = Stopwatch.StartNew();
            for (int i = 0; watch.Elapsed.TotalSeconds < seconds; ++i)
            {
                board.SetFocus(0.02 * Math.Cos(0.05 * i), 0.02 * Math.Sin(0.05 * i), 0.15);
                board.Wait(1);
            }
            Status status = board.Status;
            Console.WriteLine("moved " + status.FociSent / watch.Elapsed.TotalSeconds + " enabled " + status.Enabled + " channels " + board.Channels);
            board.Stop();
            Console.WriteLine("busy " + board.Status.Busy);
        }
    }

    static void Patterns(string port)
    {
        using (var board = new Board(port))
        {
            var words = new ushort[100 * 8];
            for (int i = 0; i < words.Length; ++i) words[i] = (ushort)(i / 100 * 10 | 180 << 8);
            board.PlayPatterns();
            int put = board.PutPatterns(words);
            while (board.Status.Busy && (board.Status.FociSent < 100 || !board.Status.Enabled)) board.Wait(1);
            Span<ushort> silent = stackalloc ushort[100];
            board.SetPattern(silent);
            Console.WriteLine("patterns " + put + " enabled " + board.Status.Enabled);
            board.Stop();
        }
    }

    static void Axes()
    {
        var array = new HaptogramArray();
        array.transform.position = new UnityEngine.Vector3(1, 2, 3);
        Focus focus = array.FocusAt(new UnityEngine.Vector3(1.01f, 2.15f, 3.02f), 1);
        Console.WriteLine("axes " + Math.Round(focus.X, 5) + " " + Math.Round(focus.Y, 5) + " " + Math.Round(focus.Z, 5));
    }

    static int Main(string[] arguments)
    {
        Console.WriteLine("version " + Library.Version);
        Compiles(arguments[0]);
        Fails();
        IsGone("reference:tile-100-wide");
        Moves("reference:tile-100-wide", 1.0);
        Patterns("reference:colorlight-5a-75e-v7.1-net");
        Axes();
        return 0;
    }
}
