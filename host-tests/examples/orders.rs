//! x
use quadcal_host_tests::accuracy::*;
fn main(){ for sc in [Scenario::Wander01,Scenario::Wander1,Scenario::Perfect,Scenario::Quiet]{ let n=200u64; let mut all=vec![]; let mut b=vec![0.0;4999]; let mut a=vec![0.0;4999]; let mut dif:Vec<f64>=vec![];
 for s in 1..=n { let r=run(&sc.twin(s)); let p=r.order_powers(); let ours=p.iter().map(|x|x.1).sum::<f64>().sqrt(); all.push((ours,s)); for (i,x) in p.iter().enumerate(){b[i]+=x.0;a[i]+=x.1;} if s%10==0 {let e=r.errors(); dif.push(e.from_reference/e.standard_error);} }
 all.sort_by(|x,y|x.0.total_cmp(&y.0)); println!("{sc:?} median {:.3e} p90 {:.3e} worst {:?}",all[100].0,all[180].0,&all[194..]); 
 let mut r:Vec<_>=(0..4999).map(|i|(a[i]/b[i],i+1)).collect(); r.sort_by(|x,y|y.0.total_cmp(&x.0)); println!("  orders {:?}  f64 dif max {:?}",&r[..6],dif.iter().cloned().fold(0.0,f64::max));
}}
