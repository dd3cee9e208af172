// SPDX-License-Identifier: Apache-2.0
// A button that is felt: a click of 0.1 s where a fingertip comes through its surface.
using Haptogram;
using UnityEngine;

public sealed class Button : MonoBehaviour
{
    public HaptogramArray haptics;
    public Transform fingertip;
    public float radius = 0.02f;

    private bool _above = true;
    private float _left;

    private void Update()
    {
        Vector3 tip = transform.InverseTransformPoint(fingertip.position);
        bool above = tip.y > 0;
        if (_above && !above && new Vector2(tip.x, tip.z).magnitude < radius) _left = 0.1f;
        _above = above;
        haptics.target = _left > 0 ? fingertip : null;
        _left -= Time.deltaTime;
    }
}
