// SPDX-License-Identifier: Apache-2.0
// A heartbeat on the palm: two beats, the second weaker, and a pause.
using Haptogram;
using UnityEngine;

public sealed class Heartbeat : MonoBehaviour
{
    public HaptogramArray haptics;
    public Transform palm;
    public float beatsPerMinute = 60;

    private void Update()
    {
        float phase = Time.time * beatsPerMinute / 60 % 1;
        haptics.strength = phase < 0.12f ? 1 : phase > 0.25f && phase < 0.37f ? 0.6f : 0;
        haptics.target = palm;
    }
}
