// SPDX-License-Identifier: Apache-2.0
// As much of Unity as the package names, so that a compiler can read the package; and its frame, to try the change of axes.
namespace UnityEngine
{
    using System;

    public class Object { }
    public class Behaviour : Object { public Transform transform = new Transform(); }
    public class MonoBehaviour : Behaviour { }

    public struct Vector2
    {
        public float x, y;
        public Vector2(float x, float y) { this.x = x; this.y = y; }
        public float magnitude => (float)Math.Sqrt(x * x + y * y);
    }

    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
        public static float Distance(Vector3 a, Vector3 b) => (float)Math.Sqrt(Math.Pow(a.x - b.x, 2) + Math.Pow(a.y - b.y, 2) + Math.Pow(a.z - b.z, 2));
    }

    public class Transform : Object
    {
        public Vector3 position;
        public Vector3 InverseTransformPoint(Vector3 p) => new Vector3(p.x - position.x, p.y - position.y, p.z - position.z);
    }

    public static class Debug
    {
        public static void LogError(object message, Object context) { Console.Error.WriteLine(message); }
        public static void LogWarning(object message, Object context) { Console.Error.WriteLine(message); }
    }

    public static class Time { public static float time = 0, deltaTime = 0; }
    public static class Mathf { public static float Clamp01(float value) => Math.Max(0, Math.Min(1, value)); }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class RangeAttribute : Attribute { public RangeAttribute(float least, float most) { } }
}
